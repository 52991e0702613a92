"""Wrong calls are refused with a sentence, at the right times, and do no harm."""

from __future__ import annotations

import ctypes
import math

import pytest

from tests.support.fmus import fmu_support as support
from tests.support.fmus.fmu_support import Fmu, Refused

FLAVOURS = ("fmi2", "fmi3", "fmi3-arrays")


def refused(fmu: Fmu, *words: str):
    """A context that expects an error, logged with these words."""

    class Expectation:
        def __enter__(self) -> None:
            self.before = len(fmu.log)

        def __exit__(self, kind: object, error: object, trace: object) -> bool:
            assert isinstance(error, Refused), "the call was accepted"
            assert error.status == 3
            status, category, message = fmu.log[self.before]
            assert (status, category) == (3, "logStatusError")
            for word in words:
                assert word in message
            return True

    return Expectation()


@pytest.mark.parametrize("flavour", FLAVOURS)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_only_finite_numbers_are_taken(flavour: str, value: float) -> None:
    with Fmu("hand", flavour) as fmu:
        fmu.start()
        fmu.set("force", 2.0)
        with refused(fmu, "'force'", "finite"):
            fmu.set("force", value)
        assert fmu.get("force") == 2.0


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_limits_of_parameters_are_kept(flavour: str) -> None:
    with Fmu("virtual_coupler", flavour) as fmu:
        with refused(fmu, "'stiffness'", "-1", "least value is 0"):
            fmu.set("stiffness", -1.0)
        with refused(fmu, "'computation_delay_ticks'", "greatest value is 8"):
            fmu.set("computation_delay_ticks", 9)
    with Fmu("signal", flavour) as fmu, refused(fmu, "'mode'", "greatest value is 4"):
        fmu.set("mode", 5)


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_a_refused_set_changes_nothing(flavour: str) -> None:
    with Fmu("hand", flavour) as fmu:
        fmu.start()
        names = ["force", "coupler_force"]
        references = (ctypes.c_uint32 * 2)(*(fmu.variables[n].valueReference for n in names))
        values = (ctypes.c_double * 2)(1.0, math.nan)
        sizes = [] if fmu.fmi2 else [ctypes.c_size_t(2)]
        with refused(fmu, "'coupler_force'"):
            fmu.call(f"Set{fmu.kind('force')}", references, ctypes.c_size_t(2), values, *sizes)
        assert [fmu.get(name) for name in names] == [0.0, 0.0]


@pytest.mark.parametrize("flavour", FLAVOURS)
@pytest.mark.parametrize("reference", [0xFFFFFFFF, 100_000, 8])
def test_unknown_value_references_are_refused(flavour: str, reference: int) -> None:
    with Fmu("hand", flavour) as fmu:
        fmu.start()
        kind = fmu.kind("force")
        value, sizes = ctypes.c_double(), [] if fmu.fmi2 else [ctypes.c_size_t(1)]
        for verb in ("Get", "Set"):
            with refused(fmu, "value reference"):
                fmu.call(
                    f"{verb}{kind}",
                    ctypes.byref(ctypes.c_uint32(reference)),
                    ctypes.c_size_t(1),
                    ctypes.byref(value),
                    *sizes,
                )


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_types_are_not_mixed_up(flavour: str) -> None:
    with Fmu("probe_types", flavour) as fmu:
        fmu.start()
        reference = ctypes.c_uint32(fmu.variables["integer_in"].valueReference)
        sizes = [] if fmu.fmi2 else [ctypes.c_size_t(1)]
        with refused(fmu, "no real variable"):
            fmu.call(
                f"Get{fmu.kind('real_in')}",
                ctypes.byref(reference),
                ctypes.c_size_t(1),
                ctypes.byref(ctypes.c_double()),
                *sizes,
            )


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_null_pointers_are_refused(flavour: str) -> None:
    with Fmu("hand", flavour) as fmu:
        fmu.start()
        sizes = [] if fmu.fmi2 else [ctypes.c_size_t(1)]
        one = ctypes.byref(ctypes.c_uint32(0))
        for verb in ("Get", "Set"):
            for arguments in ((None, None), (one, None)):
                with refused(fmu, "null pointer"):
                    fmu.call(
                        f"{verb}{fmu.kind('force')}",
                        arguments[0],
                        ctypes.c_size_t(1),
                        arguments[1],
                        *sizes,
                    )
        state = "FMUstate" if fmu.fmi2 else "FMUState"
        with refused(fmu, "state"):
            fmu.call(f"Set{state}", None)
        with refused(fmu, "state"):
            fmu.call(f"Get{state}", None)


def test_calls_on_no_instance_are_errors() -> None:
    with Fmu("hand") as fmu:
        for name in ("fmi2Reset", "fmi3Reset", "fmi2Terminate", "fmi3ExitInitializationMode"):
            function = getattr(fmu.library, name)
            function.argtypes = None
            assert function(None) == 3
        fmu.library.fmi3FreeInstance.argtypes = None
        fmu.library.fmi3FreeInstance(None)


def test_sizes_of_arrays_are_checked() -> None:
    with Fmu("object", "fmi3-arrays") as fmu:
        fmu.start()
        reference = ctypes.c_uint32(fmu.variables["force"].valueReference)
        values = (ctypes.c_double * 18)()
        for count in (0, 1, 16, 18):
            with refused(fmu, "17 elements"):
                fmu.call(
                    "SetFloat64",
                    ctypes.byref(reference),
                    ctypes.c_size_t(1),
                    values,
                    ctypes.c_size_t(count),
                )
        inside = ctypes.c_uint32(reference.value + 1)
        with refused(fmu, "inside an array"):
            fmu.call(
                "GetFloat64",
                ctypes.byref(inside),
                ctypes.c_size_t(1),
                values,
                ctypes.c_size_t(1),
            )


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_the_order_of_calls_is_enforced(flavour: str) -> None:
    with Fmu("hand", flavour) as fmu:
        with refused(fmu, "before initialisation mode"):
            fmu.step()
        with refused(fmu, "before initialisation mode"):
            fmu.get("position")
        with refused(fmu, "before initialisation mode"):
            fmu.call("ExitInitializationMode")
        fmu.enter()
        with refused(fmu, "in initialisation mode"):
            fmu.step()
        fmu.call("ExitInitializationMode")
        with refused(fmu, "while the simulation runs"):
            fmu.enter()
        fmu.step()
        fmu.call("Terminate")
        assert fmu.get("position") == 0.0
        with refused(fmu, "terminated"):
            fmu.step()
        with refused(fmu, "terminated"):
            fmu.set("force", 1.0)
        fmu.call("Reset")
        fmu.start()
        fmu.step()


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_reset_gives_the_start_values_back(flavour: str) -> None:
    with Fmu("probe_types", flavour) as fmu:
        fresh = fmu.bits("input", "parameter")
        fmu.set("integer_parameter", 11)
        fmu.set("string_in", "other")
        fmu.start()
        fmu.set("real_in", 4.0)
        fmu.step()
        fmu.call("Reset")
        assert fmu.bits("input", "parameter") == fresh


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_steps_follow_each_other_and_have_a_length(flavour: str) -> None:
    with Fmu("hand", flavour) as fmu:
        fmu.start(2.0)
        for h in (0.0, -1.0, math.nan, math.inf):
            with refused(fmu, "step"):
                fmu.step(h)
        fmu.step()
        fmu.time = 0.0
        with refused(fmu, "starts at 0 s", "ended at 2.0009765"):
            fmu.step()


def test_no_step_goes_past_the_stop_time() -> None:
    with Fmu("hand") as fmu:
        stop = ctypes.c_double(2 * support.STEP)
        zero = ctypes.c_double(0)
        fmu.call("EnterInitializationMode", False, zero, zero, True, stop)
        fmu.call("ExitInitializationMode")
        fmu.step()
        fmu.step()
        with refused(fmu, "stop time"):
            fmu.step()


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_a_fixed_step_stays_fixed(flavour: str) -> None:
    with Fmu("probe_fixed_step", flavour) as fmu:
        assert not fmu.description.coSimulation.canHandleVariableCommunicationStepSize
        fmu.start()
        fmu.step(0.01)
        fmu.step(0.01)
        with refused(fmu, "cannot change its step"):
            fmu.step(0.02)
        assert fmu.get("steps") == 2


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
@pytest.mark.parametrize(("kind", "status"), [(1, 2), (2, 3), (3, 4)])
def test_failed_steps_have_their_status(flavour: str, kind: int, status: int) -> None:
    with Fmu("probe_failure", flavour) as fmu:
        fmu.set("kind", kind)
        fmu.set("at", 3)
        fmu.start()
        for _ in range(3):
            fmu.step()
        with pytest.raises(Refused) as failure:
            fmu.step()
        assert failure.value.status == status
        assert fmu.log[-1][0] == status
        assert "as it was told to" in fmu.log[-1][2]
        if status == 2:  # a discarded step may be tried again
            assert fmu.get("value") == 3.0
            return
        with pytest.raises(Refused):
            fmu.get("value")
        if status == 3:
            fmu.call("Reset")
        else:
            with refused(fmu, "can only be freed"):
                fmu.call("Reset")


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_bad_parameters_end_initialisation_with_a_sentence(flavour: str) -> None:
    with Fmu("hand", flavour) as fmu:
        fmu.set("mass", 0.0)
        fmu.enter()
        with refused(fmu, "mass is 0 kg", "above zero"):
            fmu.call("ExitInitializationMode")


def test_outputs_can_be_read_in_initialisation_mode() -> None:
    with Fmu("virtual_coupler") as fmu:
        fmu.enter()
        fmu.set("position_a", 0.5)
        assert fmu.get("force") == 500.0
        fmu.set("stiffness", 2000.0)
        assert fmu.get("force") == 1000.0
        fmu.call("ExitInitializationMode")
        assert fmu.get("force") == 1000.0


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_information_is_logged_when_it_is_wanted(flavour: str) -> None:
    for wanted in (False, True):
        with Fmu("probe_types", flavour, logging=wanted) as fmu:
            fmu.start()
            assert [entry[1:] for entry in fmu.log] == [("logInfo", "probe_types starts.")] * wanted
    with Fmu("probe_types", flavour) as fmu:
        category = ctypes.c_char_p(b"logInfo")
        fmu.call("SetDebugLogging", True, ctypes.c_size_t(1), ctypes.byref(category))
        fmu.start()
        assert len(fmu.log) == 1
        unknown = ctypes.c_char_p(b"logNothing")
        with refused(fmu, "logNothing"):
            fmu.call("SetDebugLogging", True, ctypes.c_size_t(1), ctypes.byref(unknown))


def test_a_percent_sign_survives_an_fmi2_logger() -> None:
    """FMI 2.0 loggers take a format: whoever prints it must see the text as it was."""
    with Fmu("signal", "fmi2") as fmu:
        fmu.set("mode", 4)
        fmu.set("table_file", "100 %s %n")
        fmu.enter()
        with pytest.raises(Refused):
            fmu.call("ExitInitializationMode")
        assert "'100 %%s %%n'" in fmu.log[-1][2]


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
def test_strings_are_copied_and_limited(flavour: str) -> None:
    with Fmu("probe_types", flavour) as fmu:
        fmu.start()
        assert fmu.get("string_in").decode() == 'a "string" <&> ü \\'
        for text in ("", "x" * 511, "Bär\n"):
            fmu.set("string_in", text)
            assert fmu.get("string_out").decode() == text
        with refused(fmu, "longer than 511 bytes"):
            fmu.set("string_in", "x" * 512)


def test_wrong_tokens_are_refused() -> None:
    with Fmu("hand") as fmu:
        instantiate = fmu.library.fmi3InstantiateCoSimulation
        instantiate.argtypes = None
        instantiate.restype = ctypes.c_void_p

        def attempt(name: bytes | None, token: bytes | None, event_mode: bool) -> object:
            null, size = ctypes.c_void_p(), ctypes.c_size_t(0)
            log = fmu.fmu.logMessage
            return instantiate(
                name, token, b"", False, False, event_mode, False, null, size, null, log, null
            )

        token = fmu.description.guid.encode()
        for arguments, word in (
            ((b"x", b"other", False), "token"),
            ((b"x", None, False), "token"),
            ((None, token, False), "no name"),
            ((b"", token, False), "no name"),
            ((b"x", token, True), "event mode"),
        ):
            assert attempt(*arguments) is None
            assert word in fmu.log[-1][2]


def test_what_is_not_offered_says_so() -> None:
    with Fmu("hand") as fmu:
        fmu.start()
        for name in ("EnterEventMode", "EnterStepMode", "EnterConfigurationMode"):
            with refused(fmu, f"fmi3{name} is not supported"):
                fmu.call(name)
    with Fmu("hand", "fmi2") as fmu:
        fmu.start()
        with refused(fmu, "fmi2CancelStep is not supported"):
            fmu.call("CancelStep")
