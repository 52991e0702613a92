"""How a value changes on its way: its type, its unit, and the factor that a connection writes."""

from __future__ import annotations

from collections.abc import Mapping

from cosim.base.component import Variable, VariableType
from cosim.base.errors import InputError
from cosim.base.quantities.units import conversion
from cosim.master.assembly.connecting.ends import Pair, name_of, source_name
from cosim.master.components.interface import Interface
from cosim.scenario import Connection, Kind, Scenario


class Conversions:
    """Of all connections; ``notes`` hears where a unit is changed or taken on trust."""

    def __init__(
        self, scenario: Scenario, interfaces: Mapping[str, Interface], notes: list[str]
    ) -> None:
        self.notes = notes
        self._scenario = scenario
        self._interfaces = interfaces

    def check_unit_ignored(self, connection: Connection, pairs: list[Pair]) -> None:
        """What is to be ignored has to be there.

        Raises:
            InputError: the units agree.
        """
        if connection.ignores_unit and all(
            conversion(pair.source_unit, pair.target_unit) == (1.0, 0.0)
            and pair.source_variable.is_relative == pair.target_variable.is_relative
            for pair in pairs
        ):
            raise InputError(f"{connection}: the units of both ends agree; leave 'unit' out")

    def _is_playback(self, connection: Connection) -> bool:
        """A record keeps booleans as whole numbers; the kernel sees to it that they are 0 or 1."""
        source = self._scenario.components.get(connection.source.component)
        return source is not None and source.kind is Kind.PLAYBACK

    def of(self, connection: Connection, pair: Pair) -> tuple[float, float, bool]:
        """Gain, offset and whether a whole number becomes a real one.

        Raises:
            InputError: the types or units of both ends do not go together.
        """
        gain, offset, from_integer = self._conversion(connection, pair)
        if (connection.factor, connection.offset) == (1.0, 0.0):
            return gain, offset, from_integer
        if not pair.target_variable.type.is_float:
            raise InputError(
                f"{connection}: {name_of(self._interfaces, pair.target)} is of type "
                f"{pair.target_variable.type}; only a real input takes a factor or an offset"
            )
        factor = connection.factor
        return factor * gain, factor * offset + connection.offset, from_integer

    def _conversion(self, connection: Connection, pair: Pair) -> tuple[float, float, bool]:
        there, here = pair.source_variable, pair.target_variable
        names = f"{source_name(self._interfaces, connection, pair)} ({there.type})"
        into = f"{name_of(self._interfaces, pair.target)} ({here.type})"
        if (there.type.is_text or here.type.is_text) and there.type is not here.type:
            raise InputError(f"{names} cannot drive {into}: texts and binary data keep their type")
        self._note_items(connection, there, here)
        from_integer = here.type.is_float and not there.type.is_float
        if from_integer and there.type in {VariableType.BOOLEAN, VariableType.ENUMERATION}:
            raise InputError(f"{names} cannot drive {into}: it is not a number")
        if there.type.is_float and not here.type.is_float:
            raise InputError(f"{names} cannot drive {into}: a real value does not fit an integer")
        integer = not there.type.is_float and not here.type.is_float
        if (
            integer
            and here.type is VariableType.BOOLEAN
            and there.type is not here.type
            and (not self._is_playback(connection))
        ):
            raise InputError(f"{names} cannot drive {into}: only a boolean can")
        if connection.ignores_unit:
            return (1.0, 0.0, from_integer)
        ends = {there.is_relative: pair.source_unit, here.is_relative: pair.target_unit}
        if len(ends) == 2 and (absolute := ends[False]) is not None and absolute.offset:
            raise InputError(
                f"{names} cannot drive {into}: one is a difference (relativeQuantity), "
                f"the other an absolute value in {absolute.name}"
            )
        factor = conversion(pair.source_unit, pair.target_unit)
        if factor is None and (unknown := _known_by_name_only(pair)):
            self.notes.append(
                f"{connection}: nobody says what {unknown} measures, so {there.unit} passes to "
                f"{here.unit} as it is (unit: ignore says so without a note)"
            )
            return (1.0, 0.0, from_integer)
        if factor is None:
            raise InputError(
                f"{source_name(self._interfaces, connection, pair)} is in {there.unit} and "
                f"{name_of(self._interfaces, pair.target)} in {here.unit}; they measure different "
                "things (unit: ignore on the connection passes the number as it is)"
            )
        if factor != (1.0, 0.0):
            if not here.type.is_float:
                raise InputError(f"{names} in {there.unit} cannot drive {into} in {here.unit}")
            self.notes.append(f"{connection}: {there.unit} is converted to {here.unit}")
        return (*factor, from_integer)

    def _note_items(self, connection: Connection, there: Variable, here: Variable) -> None:
        """A number of an enumeration passes, whatever it is called at either end."""
        names = {number: name for name, number in (here.items or {}).items()}
        for name, number in (there.items or {}).items():
            if names.get(number, name) != name:
                self.notes.append(
                    f"{connection}: {number} is {name} at one end and {names[number]} at the other"
                )
                return


def _known_by_name_only(pair: Pair) -> str:
    """The unit of either end that is only a word."""
    units = (pair.source_unit, pair.target_unit)
    return next((unit.name for unit in units if unit is not None and unit.exponents is None), "")
