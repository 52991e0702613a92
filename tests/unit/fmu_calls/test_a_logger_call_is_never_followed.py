"""What an FMU hands to its logger is read with care: nothing that comes back is dereferenced."""

from __future__ import annotations

import ctypes
from pathlib import Path

import pytest

from cosim.base.errors import CohapticError
from cosim.master.kernel.native import library
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import run, scenario_of

DISCARD, ERROR = 2, 3
FAILS = """
    static int hook(Foreign *m, const char *call)
    {
        if (!is(call, "DoStep"))
            return 0;
        %(says)s
        return %(status)d;
    }
    #define HOOK hook
"""
SPAWN = """
    typedef unsigned long pthread_t;
    int pthread_create(pthread_t *, const void *, void *(*)(void *), void *);
    int pthread_join(pthread_t, void **);
    static void *chat(void *m)
    {
        for (int i = 0; i < 2000; i++)
            say(m, i % 2 ? 1 : 0, "a thread speaks");
        return 0;
    }
    static void chat_in_threads(Foreign *m)
    {
        pthread_t threads[4];
        for (int i = 0; i < 4; i++)
            pthread_create(&threads[i], 0, chat, m);
        for (int i = 0; i < 4; i++)
            pthread_join(threads[i], 0);
    }
"""


def scenario(fmu: Path) -> str:
    return f"duration: 2\nbase_rate: 1\ncomponents:\n  f: {{fmu: {fmu}, rate: 1}}\n"


def speaker(folder: Path, version: int, says: str, status: int = ERROR, before: str = "") -> Path:
    """An FMU that says something in its step and returns a status."""
    variables = scalar(version, "u", 1, causality="input", start="0")
    snippet = before + FAILS.replace("%(says)s", says).replace("%(status)d", str(status))
    return foreign_fmu(folder, version, variables, snippet=snippet)


def sentence(folder: Path, version: int, says: str, before: str = "") -> str:
    fmu = speaker(folder, version, says, before=before)
    with pytest.raises(CohapticError) as caught:
        run(scenario_of(folder, scenario(fmu)))
    return str(caught.value)


def log2(message: str) -> str:
    return f'm->log2(m->environment, "n", {ERROR}, "c", {message});'


@pytest.mark.parametrize("environment", ["0", "(void *)8", "m", "(void *)-1"])
@pytest.mark.parametrize("version", [2, 3])
def test_another_environment_is_looked_up_and_not_followed(
    tmp_path: Path, version: int, environment: str
) -> None:
    call = {
        2: f'm->log2({environment}, 0, 3, 0, "it is broken");',
        3: f'm->log3({environment}, 3, 0, "it is broken");',
    }
    assert sentence(tmp_path, version, call[version]).endswith("it said: it is broken")


@pytest.mark.parametrize(
    ("message", "said"),
    [
        (r'"%.*s!", 3, "abcdef"', "abc!"),
        (r'"%.2s!", "abcdef"', "ab!"),
        (r'"%*d|%-5s|", 4, 7, "x"', "7|x|"),
        (r'"%Lf %d", 1.5L, 4', "1.5 4"),
        (r'"%n%d", (int *)8, 4', "4"),
        (r'"%s %d", (const char *)0, 4', "(null) 4"),
        (r'"%o %x", 8, 255', "10 ff"),
        (r'"two\nlines"', "two lines"),
    ],
)
def test_a_format_takes_what_printf_takes(tmp_path: Path, message: str, said: str) -> None:
    assert sentence(tmp_path, 2, log2(message)).endswith(f"it said: {said}")


def test_text_without_an_end_is_read_to_its_precision(tmp_path: Path) -> None:
    """The page behind the text does not exist."""
    says = """
        extern void *mmap(void *, unsigned long, int, int, int, long);
        extern int munmap(void *, unsigned long);
        char *pages = mmap(0, 8192, 3, 0x22, -1, 0);
        munmap(pages + 4096, 4096);
        for (int i = 4092; i < 4096; i++)
            pages[i] = 'z';
    """ + log2('"%.*s", 4, pages + 4092')
    assert sentence(tmp_path, 2, says).endswith("it said: zzzz")


@pytest.mark.parametrize("version", [2, 3])
def test_threads_may_speak_at_once(tmp_path: Path, version: int) -> None:
    says = 'chat_in_threads(m); say(m, 3, "it is broken");'
    assert sentence(tmp_path, version, says, SPAWN).endswith("it said: it is broken")


@pytest.mark.parametrize("version", [2, 3])
def test_chatter_does_not_bury_the_reason(tmp_path: Path, version: int) -> None:
    says = """
        say(m, 3, "it is broken");
        for (int i = 0; i < 10000; i++)
            say(m, 0, "all is well");
    """
    assert sentence(tmp_path, version, says).endswith("it said: it is broken")


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("letter", ["ab", "\u00e9", "\u20ac"])
def test_a_message_without_an_end_in_sight_is_cut(
    tmp_path: Path, version: int, letter: str
) -> None:
    """A reason that is longer than the log is still a reason, of whole characters."""
    says = f"""
        static char text[20001];
        for (int i = 0; i < 20000; i++)
            text[i] = "{letter}"[i % (sizeof("{letter}") - 1)];
        say(m, 3, text);
    """
    said = sentence(tmp_path, version, says).partition("it said: ")[2]
    assert said.endswith(" (\u2026)")
    text = said.removesuffix(" (\u2026)")
    assert 500 < len(text) < 2100
    assert text == (letter * 2000)[: len(text)]


def test_what_is_forgotten_is_forgotten_whole(tmp_path: Path) -> None:
    """Of an older message no half is left, whose first letter would be taken for its status."""
    says = """
        char text[] = "1 22 333 4444 55555 666666 7777777";
        for (int i = 0; i < 5000; i++)
            say(m, 1, text + i % 7);
    """
    with (
        pytest.raises(CohapticError),
        assemble(scenario_of(tmp_path, scenario(speaker(tmp_path, 3, says)))) as simulation,
    ):
        simulation.run()
    whole = "1 22 333 4444 55555 666666 7777777"
    said = simulation.outcome.said["f"]
    assert {each.text for each in said} == {whole[i:].strip() for i in range(7)}
    assert {each.status for each in said} == {"warning"}


@pytest.mark.parametrize(("status", "graded"), [(99, "9"), (-1, "9"), (5, "pending")])
@pytest.mark.parametrize("message", ["0", '"x"'])
def test_no_message_and_no_status_of_the_standard(
    tmp_path: Path, message: str, status: int, graded: str
) -> None:
    says = f'm->log3(m->environment, {status}, "", {message});'
    with assemble(scenario_of(tmp_path, scenario(speaker(tmp_path, 3, says, 0)))) as simulation:
        simulation.run()
    said = {str(each) for each in simulation.outcome.said.get("f", ())}
    assert said == (set() if message == "0" else {f"{graded}: x (2 times)"})


def test_chatter_alone_is_told_shortly(tmp_path: Path) -> None:
    says = 'say(m, 0, "1"); say(m, 0, "2"); say(m, 0, "3"); say(m, 0, "4");'
    assert sentence(tmp_path, 3, says).endswith("it said: 2 / 3 / 4")


@pytest.mark.parametrize("version", [2, 3])
def test_a_message_after_the_end_harms_nothing(tmp_path: Path, version: int) -> None:
    log = {2: library().kernel_log_fmi2, 3: library().kernel_log_fmi3}[version]
    with assemble(scenario_of(tmp_path, scenario(speaker(tmp_path, version, "", 0)))) as simulation:
        simulation.run()
        environment = ctypes.c_void_p(simulation.fmus["f"]._residence.log.address)
    status, text = ctypes.c_int(ERROR), ctypes.c_char_p(b"late")
    if version == 2:
        log(environment, None, status, None, text)
    else:
        log(environment, status, None, text)
    assert simulation.fmus["f"].messages() == ["late"]  # stray, since its log is closed


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("status", [DISCARD, ERROR])
def test_a_refused_choice_of_categories_is_no_error(
    tmp_path: Path, version: int, status: int
) -> None:
    snippet = f"""
        static int hook(Foreign *m, const char *call)
        {{
            return is(call, "SetDebugLogging") ? {status} : 0;
        }}
        #define HOOK hook
    """
    before = '<LogCategories><Category name="logStatusError"/></LogCategories>'
    variables = scalar(version, "u", 1, causality="input", start="0")
    fmu = foreign_fmu(tmp_path, version, variables, snippet=snippet, before=before)
    run(scenario_of(tmp_path, scenario(fmu)))


@pytest.mark.parametrize("version", [2, 3])
def test_a_function_that_is_never_called_may_be_missing(tmp_path: Path, version: int) -> None:
    variables = scalar(version, "u", 1, causality="input", start="0")
    fmu = foreign_fmu(tmp_path, version, variables, snippet="#define WITHOUT_TEXTS\n")
    run(scenario_of(tmp_path, scenario(fmu)))
