"""What help(), dir() and print tell of elements and rooms: what users call, and no imports."""

import inspect
import pydoc
import re
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar, spatial
from flexmb.elements.element_text import deformations_of

ROOMS = (planar, spatial, fm.sections, fm.materials, fm.blocks, fm.plot, fm.linear, fm.motion, fm.design, fm.control)
ELEMENTS = {
    f"{room.__name__.rpartition('.')[2]}.{name}": getattr(room, name)
    for room in (planar, spatial)
    for name in dir(room)
}


@pytest.mark.parametrize("room", [fm, fm.spacar, *ROOMS], ids=lambda room: room.__name__)
def test_rooms_list_what_they_offer(room):
    names = dir(room)
    assert names == list(room.__all__)
    assert len(names) > 1
    if room is not fm:
        assert not [name for name in names if inspect.ismodule(getattr(room, name)) or name.startswith("_")]


@pytest.mark.parametrize("name", ELEMENTS)
def test_help_tells_of_the_element(name):
    element = ELEMENTS[name]
    assert isinstance(element, fm.Element)
    told = pydoc.plain(pydoc.render_doc(element))
    assert f"    {name.replace('pin_body', 'rigid_beam')}: " in told
    # Its deformations up to the last, what it joins and what it takes.
    last = getattr(inspect.signature(element.deformation).return_annotation, "dim_str", "0")
    if last.isdecimal() and int(last):
        assert re.search(rf"\be{last}\b", told)
        assert "m]" in told or "rad]" in told
    assert all(re.search(rf"\b{word}\b", told) for word in [*element.properties, *element.option_names])
    line = repr(element)
    assert "\n" not in line
    assert " at 0x" not in line + told
    assert name.rpartition(".")[2] in fm.__dict__[name.partition(".")[0]].__doc__


def test_the_manual_has_the_deformations_of_every_element():
    """By number and name, those of the default order, with shear where there is that option."""
    manual = (Path(__file__).parents[2] / "notebooks" / "README.md").read_text()
    rows = re.findall(r"^\| ((?:`(?:planar|spatial)\.\w+`(?:, )?)+) \| (.*) \|$", manual, re.MULTILINE)
    found = {name: said for names, said in rows for name in re.findall(r"`([\w.]+)`", names)}
    assert found.keys() == ELEMENTS.keys()
    for name, said in found.items():
        element = ELEMENTS[name](shear=True) if "shear" in ELEMENTS[name].option_names else ELEMENTS[name]
        assert re.sub(r" \[(m|rad)\]", "", said) == (deformations_of(element) or "none"), name


def test_an_element_of_ones_own_is_told_by_its_function():
    def pull(p: fm.Point2, q: fm.Point2, *, ref, gain: float = 2.0):
        """Distance, times a gain [m]."""
        return jnp.zeros(1)

    assert repr(fm.Element(pull)) == "<pull: joins p, q; takes gain>"
    assert "pull: Distance, times a gain [m]." in pydoc.plain(pydoc.render_doc(fm.Element(pull)))
    assert str(fm.Element.__doc__).startswith("An element type: the deformation function")
    assert repr(planar.spectral_beam(3)).startswith("<planar.spectral_beam: ")
    assert repr(planar.spectral_beam(3)).endswith("order=3, shear=False>")


@pytest.mark.slow
def test_signs_are_as_told():
    """Turns from the chord times length, to first order in a small turn."""
    small, l0 = 1e-6, 0.2
    flat = planar.beam.reference([np.zeros(2), np.zeros(1), np.array([l0, 0]), np.zeros(1)])
    for end, expected in ((1, [0, 1, 0]), (3, [0, 0, -1])):
        x = [np.array(part) for part in flat]
        x[end] = np.array([small])
        found = jax.jit(planar.beam.deformation)(*x, ref=flat)
        np.testing.assert_allclose(found / (small * l0), expected, atol=1e-5)
    start = np.array([1.0, 0, 0, 0])
    ref = spatial.beam.reference([np.zeros(3), start, np.array([l0, 0, 0]), start])
    # By ends and axes: x twists, y bends along z, z along y.
    told = {(1, 1): (1, -1), (3, 1): (1, 1), (1, 2): (2, -1), (3, 2): (3, 1), (1, 3): (4, -1), (3, 3): (5, 1)}
    for (end, axis), (which, sign) in told.items():
        x = [np.array(part) for part in ref]
        x[end] = start + small / 2 * np.eye(4)[axis]
        found = jax.jit(spatial.beam.deformation)(*x, ref=ref, y=np.array([0.0, 1, 0]))
        np.testing.assert_allclose(found / (small * l0), sign * np.eye(6)[which], atol=1e-5)
