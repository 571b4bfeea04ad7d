"""Functions of every module: addresses, rounding, texts."""

import random

from hypothesis import given
from hypothesis import strategies as st

from achse.native.backend import (
    Effort,
    MachineCode,
    ModuleBuilder,
    address_of,
    compile_module,
)
from achse.plc.machine.support import AREA_WORDS, CALLBACKS, INTERFACE, Support
from achse.plc.memory import ADDRESS_BITS
from achse.st.check.folding import rounded


def _loaded() -> MachineCode:
    module = ModuleBuilder()
    support = Support(module)
    module.table("entries", [])
    for target in (support.locate, support.rounded, support.find, support.length(2),
                   support.compare(1), support.compare(2)):  # fmt: skip
        signature = target.signature
        name = f"run {target.symbol[2:-1]}"
        b = module.function(name, signature.parameters, signature.results, exported=True)
        b.return_(*b.call(target, *b.parameters))
    content = compile_module(module, Effort.FAST)
    return MachineCode(content, module.interface, dict.fromkeys(CALLBACKS, int))


CODE = _loaded()


def test_the_interface_is_the_same_for_all_modules() -> None:
    module = ModuleBuilder()
    Support(module)
    assert module.interface == INTERFACE


@given(st.floats())
def test_rounding_is_that_of_folded_constants(value: float) -> None:
    assert CODE.function("run rounded")(value) == rounded(value)


def test_only_what_is_in_an_area_is_found() -> None:
    memory = bytearray(64)
    areas = CODE.words(AREA_WORDS)
    areas[4], areas[5] = address_of(memory), len(memory)
    locate = CODE.function("run locate")
    start = 2 << ADDRESS_BITS
    assert locate(start + 8, 56) == address_of(memory) + 8
    for address, size in (
        (start + 8, 57), (start + 64, 1), (start - 1, 1), (0, 1), (1 << 63, 1),
        (9 << ADDRESS_BITS, 1), (8 << ADDRESS_BITS, 1), ((1 << 64) - 1, 2), (3 << ADDRESS_BITS, 1),
    ):  # fmt: skip
        assert not locate(address, size)


WIDE = st.text(st.sampled_from("abĀ𐀀"), max_size=4).map(lambda text: text.encode("utf-16-le"))
NARROW = st.binary(max_size=6)


@given(st.one_of(st.tuples(NARROW, NARROW, st.just(1)), st.tuples(WIDE, WIDE, st.just(2))))
def test_texts_compare_and_are_found(drawn: tuple[bytes, bytes, int]) -> None:
    left, right, unit = drawn
    one, other = bytearray(left + b"\0\0"), bytearray(right + b"\0\0")
    texts = (address_of(one), len(left), address_of(other), len(right))
    order = CODE.function(f"run compare.{unit}")(*texts)
    units = [
        [int.from_bytes(text[at : at + unit], "little") for at in range(0, len(text), unit)]
        for text in (left, right)
    ]
    assert (order > 0) - (order < 0) == (units[0] > units[1]) - (units[0] < units[1])
    position = next(
        (
            at + 1
            for at in range(len(units[0]) - len(units[1]) + 1)
            if units[0][at : at + len(units[1])] == units[1]
        ),
        0,
    )
    assert CODE.function("run find")(*texts, unit) == (position if right else 0)


def test_a_wide_text_ends_at_its_nul() -> None:
    dice = random.Random(5)
    for _ in range(30):
        text = bytearray(dice.choice((0, 0, 1, 255)) for _ in range(12))
        units = memoryview(text).cast("H")
        expected = next((2 * at for at, unit in enumerate(units) if not unit), 12)
        assert CODE.function("run length.2")(address_of(text), 12) == expected
