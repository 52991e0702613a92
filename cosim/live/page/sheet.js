// What a study asks: a sheet over the scene, with questions, a break, or a button to begin.

const QUIET_MS = 300; // who was pressing something when the sheet came has not answered it
const MOST_BOXES = 11; // a longer scale is a slider

export class Sheet {
  #form;
  #answer;
  #number = null;
  #reads = new Map();
  #opening = null;
  title = null;
  heading = "";

  /** ``answer`` is given what the participant says. */
  constructor(form, answer) {
    this.#form = form;
    this.#answer = answer;
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      if (this.#number === null) return;
      const answers = Object.fromEntries([...this.#reads].map(([name, read]) => [name, read()]));
      this.#answer({ number: this.#number, answers });
    });
  }

  show(told) {
    this.title = told.title;
    this.heading = told.heading;
    clearInterval(this.#opening);
    this.#reads.clear();
    this.#number = told.button ? told.number : null;
    this.#form.hidden = this.#number === null;
    if (this.#form.hidden) return;
    const button = element("button", { type: "submit", textContent: told.button });
    const leave = element("button", { type: "button", textContent: "Leave the study", className: "leave" });
    leave.addEventListener("click", () => this.#answer({ number: told.number, leave: true }));
    const bar = element("div", { className: "bar" }, button, leave);
    const heading = element("h2", { textContent: told.heading });
    this.#form.replaceChildren(heading, ...(told.questions ?? []).map((each) => this.#field(each)), bar);
    this.#form.inert = true;
    setTimeout(() => {
      this.#form.inert = false;
      (this.#form.querySelector("[data-problem] input, input, textarea") ?? button).focus();
    }, QUIET_MS);
    if (told.wait) this.#open(button, told.button, performance.now() + 1e3 * told.wait);
  }

  /** Nobody is there any more who could take an answer. */
  over() {
    if (this.title === null) return;
    this.#number = null;
    this.#form.hidden = false;
    clearInterval(this.#opening);
    this.#form.replaceChildren(element("h2", { textContent: "The session is over. Thank you." }));
  }

  /** The button counts the rest of a break down. */
  #open(button, text, at) {
    const count = () => {
      const left = Math.ceil((at - performance.now()) / 1e3);
      button.disabled = left > 0;
      button.textContent = left > 0 ? `${text} in ${left} s` : text;
      if (left <= 0) clearInterval(this.#opening);
    };
    count();
    this.#opening = setInterval(count, 200);
  }

  #field(question) {
    const id = `question-${question.name}`;
    const field = element("fieldset", { id }, element("legend", { textContent: question.ask }));
    const [inputs, read] = inputsOf(question, id);
    field.append(...inputs);
    this.#reads.set(question.name, read);
    if (question.problem) {
      field.dataset.problem = "";
      field.append(element("p", { className: "problem", role: "alert", textContent: question.problem }));
    }
    return field;
  }
}

function element(name, properties, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

/** What is shown of a question, and what reads the answer as a text. */
function inputsOf(question, id) {
  const { kind, least, most, labels, given } = question;
  if (kind === "yes_no") return choices([["y", "Yes"], ["n", "No"]], given, id);
  if (kind === "choice") return choices(labels.map((each) => [each, each]), given, id);
  if (kind === "scale") {
    const step = question.step ?? 1;
    const count = Math.floor((most - least) / step + 1e-9) + 1;
    if (count > MOST_BOXES) return slider(question, step);
    const values = Array.from({ length: count }, (_, index) => String(least + index * step));
    const [boxes, read] = choices(values.map((each) => [each, each]), given, id);
    return [ends(labels, ...boxes), read];
  }
  const input = kind === "text" ? element("textarea", { rows: 3, value: given })
    : element("input", { type: "text", inputMode: "decimal", autocomplete: "off", value: given });
  input.setAttribute("aria-label", question.ask);
  return [[input], () => input.value];
}

function choices(pairs, given, name) {
  const rows = pairs.map(([value, text]) => element("label", {},
    element("input", { type: "radio", name, value, checked: value === given }), text));
  const read = () => rows.map((row) => row.firstChild).find((each) => each.checked)?.value ?? "";
  return [rows, read];
}

/** A slider that nobody has touched is no answer. */
function slider({ ask, least, most, labels, given }, step) {
  const input = element("input", { type: "range", min: least, max: most, step, value: given || (least + most) / 2 });
  input.setAttribute("aria-label", ask);
  input.classList.toggle("untouched", !given);
  for (const kind of ["input", "click", "keydown"]) {
    input.addEventListener(kind, (event) => {
      if (event.key !== "Tab") input.classList.remove("untouched");
    });
  }
  return [ends(labels, input), () => (input.classList.contains("untouched") ? "" : input.value)];
}

function ends([low, high], ...between) {
  const end = (text) => element("span", { className: "end", textContent: text ?? "" });
  return [end(low), ...between, end(high)];
}
