"""Python components with texts and binary values: one that counts aloud, one that repeats."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from cosim.base.component import Causality, Cells, Component, Setup, Variable, VariableType
from cosim.base.texts import TextCells


def text(name: str, causality: Causality, **more: Any) -> Variable:
    """A String."""
    kind = more.pop("type", VariableType.STRING)
    return Variable(name=name, type=kind, causality=causality, variability="discrete", **more)


class Counter(Component):
    """Says at tick k the number k, as a number, a text, and binary data with a zero byte in it."""

    feedthrough = False

    @property
    def variables(self) -> Sequence[Variable]:
        """``number``, ``word``, ``data`` and two ``names``."""
        return [
            Variable(name="number", type=VariableType.INT64, causality=Causality.OUTPUT),
            text("word", Causality.OUTPUT, start="none"),
            text("data", Causality.OUTPUT, type=VariableType.BINARY),
            text("names", Causality.OUTPUT, shape=(2,)),
        ]

    def bind_texts(self, inputs: Mapping[str, TextCells], outputs: Mapping[str, TextCells]) -> None:
        """Keep the outputs."""
        self.texts = outputs

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Keep the output."""
        self.number = outputs["number"]
        self.every = int(setup.parameters.get("every", 1))

    def evaluate(self, tick: int) -> None:
        """Say it."""
        value = tick // self.every
        self.number[0] = value
        self.texts["word"][0] = f"n°{value}"
        self.texts["data"][0] = b"\0" + str(value).encode()
        self.texts["names"][0], self.texts["names"][1] = f"a{value}", f"b{value}"

    def save(self) -> None:
        """Nothing: all follows from the tick."""

    def load(self, values: None) -> None:
        """Nothing to load."""


class Repeater(Component):
    """Puts out what it was given before."""

    feedthrough = False

    @property
    def variables(self) -> Sequence[Variable]:
        """Inputs as the outputs of a :class:`Counter`, and what was last read of them."""
        return [
            Variable(name="number", type=VariableType.INT64, causality=Causality.INPUT, start=-1),
            text("word", Causality.INPUT, start="n°-1"),
            text("data", Causality.INPUT, type=VariableType.BINARY, start=b"\x00-1"),
            text("names", Causality.INPUT, shape=(2,)),
            text("heard", Causality.OUTPUT, start="nothing"),
            text("seen", Causality.OUTPUT, type=VariableType.BINARY),
        ]

    def bind_texts(self, inputs: Mapping[str, TextCells], outputs: Mapping[str, TextCells]) -> None:
        """Keep both."""
        self.inputs, self.outputs = inputs, outputs

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Remember nothing yet."""
        self.last: list[Any] = ["", ""]

    def evaluate(self, tick: int) -> None:
        """Show what was heard at the step before."""
        self.outputs["heard"][0] = self.last[0]
        self.outputs["seen"][0] = self.last[1].encode()

    def step(self, tick: int) -> None:
        """Hear."""
        self.last = [self.inputs["word"][0], self.inputs["data"][0].decode()]

    def save(self) -> list[Any]:
        """What was heard."""
        return list(self.last)

    def load(self, values: list[Any]) -> None:
        """Go on from there."""
        self.last = list(values)
