"""Surfaces taken apart into levels and put together, and edited at any level."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import henkei as hk
from cages import CAGES, WAYS, fine, prism, shuffled
from data import real
from henkei import shapes
from henkei.design.filters import INTERPOLATING, filters
from henkei.design.pyramid import Pyramid
from henkei.errors import Cancelled, Infeasible, InvalidInput, NotFinite
from henkei.mesh import Attributes, Mesh, PolygonMesh
from henkei.shapes import tetrahedron_cage, torus_cage
from topologies import grid, tube

SUPPORTS = [{}, {"support": 0}, {"support": 2}, {"interpolating": True}]
INTO = {None: "auto", False: "triangles", True: "quads"}

ways = pytest.mark.parametrize(("name", "quads"), WAYS)
supports = pytest.mark.parametrize("support", SUPPORTS, ids=str)


def pyramid(
    name: str = "icosahedron", quads: bool | None = None, levels: int = 2, seed: int = 0, **support
) -> Pyramid:
    """Of a refined cage with noise of all levels."""
    cage = CAGES[name]()
    positions = fine(cage, levels, quads).vertices
    positions = positions + np.random.default_rng(seed).normal(0, 0.1, positions.shape)
    return Pyramid.on(cage, positions, refinement=INTO[quads], **support)


def error(a: Pyramid, b: Pyramid) -> float:
    """The largest difference in any level."""
    pairs = zip(a.approximations, b.approximations, strict=True)
    return max(float(np.abs(x - y).max()) for x, y in pairs)


def fresh(edited: Pyramid, **support) -> Pyramid:
    """The finest surface analysed again."""
    into = INTO[edited.hierarchy[0].quads]
    return Pyramid.on(edited.surface(0), edited.positions(), refinement=into, **support)


@ways
@supports
def test_synthesis_undoes_analysis(name, quads, support):
    made = pyramid(name, quads, **support)
    again = made.with_detail(1.0)
    assert error(made, again) < 2e-14
    for wavelets, coarse, detail, finer in zip(
        made.wavelets, made.approximations, made.details, made.approximations[1:], strict=False
    ):
        between = filters(
            wavelets.coarse.connectivity,
            wavelets.fine.connectivity,
            wavelets.coarse.number,
            support.get("support", INTERPOLATING if support else None),
        )
        assert np.abs(between.analysis @ finer - coarse).max() < 1e-13
        assert np.abs(between.details @ finer - detail).max() < 1e-13
        assert np.abs(between.synthesis @ coarse + between.wavelets @ detail - finer).max() < 1e-13


@ways
def test_each_level_is_nearest_in_the_sense_of_least_squares(name, quads):
    """By a Cholesky factor of the inner products, dense."""
    made = pyramid(name, quads)
    root = np.linalg.cholesky(made.hierarchy[2].products.toarray()).T
    hats = np.eye(made.hierarchy[2].size)
    for level in (1, 0):
        hats = hats @ made.hierarchy[level + 1].prolongation.toarray()
        best = np.linalg.lstsq(root @ hats, root @ made.positions(), rcond=None)[0]
        assert np.abs(best - made.approximations[level]).max() < 1e-12
        missed = made.positions() - made.positions(detail=level)
        assert np.abs(hats.T @ made.hierarchy[2].products @ missed).max() < 1e-13


@ways
@supports
def test_what_is_linear_on_each_face_of_the_cage_has_no_details(name, quads, support):
    cage = CAGES[name]()
    made = Pyramid.on(cage, fine(cage, 2, quads).vertices, refinement=INTO[quads], **support)
    assert max(np.abs(d).max() for d in made.details) < 1e-13
    assert np.abs(made.approximations[0] - cage.vertices).max() < 1e-13


@ways
def test_a_surface_in_any_order(name, quads):
    mesh = shuffled(fine(CAGES[name](), 2, quads), 4)
    mesh = type(mesh)(
        mesh.vertices + np.random.default_rng(1).normal(0, 0.1, mesh.vertices.shape), mesh.faces
    )
    made = Pyramid.of(mesh, 2)
    assert (made.levels, made.hierarchy[0].quads) == (2, quads)
    assert np.array_equal(made.as_given().vertices, mesh.vertices)
    assert np.array_equal(made.as_given().faces, mesh.faces)
    assert np.array_equal(made.positions(), mesh.vertices[made.order])
    assert error(made, fresh(made)) == 0
    moved = made.edited(1, displacement=np.ones((len(made.approximations[1]), 3)))
    assert np.abs(moved.as_given().vertices - mesh.vertices - 1).max() < 1e-12


def test_attributes_of_the_finest_are_found_at_all_levels():
    for cage in (grid(2, 1), prism(5)):
        flat = shuffled(fine(cage, 2), 3)
        corner = flat.vertices[flat.indices] * 2
        face = corner.reshape(len(flat.faces), -1, 3).mean(axis=1)
        attributes = Attributes(
            vertex={"place": flat.vertices, "normal": flat.vertices},
            corner={"place": corner, "number": np.arange(len(corner))},
            face={"label": face[:, 0] > 0, "middle": face},
        )
        made = Pyramid.of(type(flat)(flat.vertices, flat.faces, attributes=attributes), 2)
        for level in range(3):
            surface = made.surface(level)
            own = surface.attributes
            assert set(own.vertex) == {"place"}
            assert np.abs(own.vertex["place"] - surface.vertices).max() < 1e-14
            assert np.abs(own.corner["place"] - 2 * surface.vertices[surface.indices]).max() < 1e-13
            at = surface.vertices[surface.indices]
            low, high = (f.reduceat(at, surface.offsets[:-1]) for f in (np.minimum, np.maximum))
            middle = own.face["middle"] / 2
            assert ((low < middle + 1e-12) & (middle < high + 1e-12)).all()
        assert set(made.as_given().attributes.vertex) == {"place"}
        assert np.array_equal(made.as_given().attributes.corner["number"], np.arange(len(corner)))
        carried = fresh(made)
        for domain in ("vertex", "corner", "face"):
            for key, values in getattr(made.surface(0).attributes, domain).items():
                assert np.array_equal(getattr(carried.surface(0).attributes, domain)[key], values)


def test_surfaces_of_levels():
    made = pyramid("hexagonal prism")
    assert [made.surface(k).face_count for k in range(3)] == [9, 38, 152]
    assert isinstance(made.cage, PolygonMesh)
    assert np.array_equal(made.surface(1).vertices, made.approximations[1])
    finest = made.surface(detail=0)
    flat = fine(made.cage, 2)
    assert np.abs(finest.vertices - flat.vertices).max() < 1e-14
    assert np.array_equal(finest.faces, flat.faces)
    assert isinstance(pyramid().surface(), Mesh)
    assert repr(made) == "Pyramid(2 levels, 9 faces to 152 quads)"


@pytest.mark.parametrize("frames", [True, False])
@supports
@ways
def test_an_edit_that_changes_nothing(name, quads, support, frames):
    made = pyramid(name, quads, **support)
    for level in range(3):
        same = made.edited(level, made.approximations[level], frames=frames)
        assert error(made, same) < 1e-12


@settings(max_examples=15, deadline=None)
@given(
    name=st.sampled_from(list(CAGES)),
    support=st.sampled_from(SUPPORTS),
    level=st.integers(0, 2),
    seed=st.integers(0, 99),
)
def test_details_follow_a_rigid_motion(name, support, level, seed):
    rng = np.random.default_rng(seed)
    made = pyramid(name, seed=seed, **support)
    turn, shift = Rotation.random(random_state=seed).as_matrix(), rng.normal(size=3)
    moved = made.edited(level, made.approximations[level] @ turn.T + shift)
    for before, after in zip(made.approximations, moved.approximations, strict=True):
        assert np.abs(before @ turn.T + shift - after).max() < 1e-10


def test_details_follow_a_rigid_motion_where_faces_have_no_area():
    """Of a level that is a line, and of one with whole regions in one point."""
    cage = grid(4, 4)
    turn = Rotation.from_rotvec([0.3, -1.2, 0.5]).as_matrix()
    for squeezed in (cage.vertices * [1, 0, 0], np.maximum(cage.vertices, [0.6, 0.6, 0])):
        flat = fine(Mesh(squeezed, cage.faces), 2).vertices
        points = flat + np.random.default_rng(0).normal(0, 1e-3, flat.shape)
        made = Pyramid.on(cage, points, interpolating=True)
        made = made.edited(0, squeezed, frames=False)
        moved = made.edited(0, squeezed @ turn.T)
        if np.linalg.matrix_rank(squeezed) > 1:
            assert np.abs(made.positions() @ turn.T - moved.positions()).max() < 1e-10
        else:
            lengths = [np.linalg.norm(d, axis=1) for d in (made.details[0], moved.details[0])]
            assert np.abs(lengths[0] - lengths[1]).max() < 1e-12


@settings(max_examples=10, deadline=None)
@given(name=st.sampled_from(list(CAGES)), level=st.integers(0, 2), seed=st.integers(0, 99))
def test_without_frames_the_surface_is_linear_in_the_edit(name, level, seed):
    rng = np.random.default_rng(seed)
    made = pyramid(name)
    a, b = rng.normal(size=(2, len(made.approximations[level]), 3))

    def change(move):
        return made.edited(level, displacement=move, frames=False).positions() - made.positions()

    assert np.abs(change(a) + 2 * change(b) - change(a + 2 * b)).max() < 1e-12


@supports
@pytest.mark.parametrize("name", ["torus of triangles", "hexagonal prism", "open prism"])
def test_an_edited_surface_has_the_levels_it_says(name, support):
    """Its own analysis gives the shape that was asked for, and the same details."""
    made = pyramid(name, **support)
    target = made.approximations[1] + np.random.default_rng(5).normal(
        size=(made.hierarchy[1].size, 3)
    )
    for frames in (True, False):
        edited = made.edited(1, target, frames=frames)
        assert np.array_equal(edited.approximations[1], target)
        again = fresh(edited, **support)
        assert error(edited, again) < 1e-12
        assert (
            max(np.abs(a - b).max() for a, b in zip(edited.details, again.details, strict=True))
            < 1e-12
        )
        lengths = [np.linalg.norm(p.details[1], axis=1) for p in (made, edited)]
        assert np.abs(lengths[0] - lengths[1]).max() < 1e-12
    assert np.array_equal(made.edited(1, target, frames=False).details[1], made.details[1])


def test_a_bent_arm_keeps_its_wrinkles():
    """A wrinkled tube, bent: nearer to the wrinkled bent tube if details turn."""
    cage = tube(8, 8, height=6.0)
    flat = fine(cage, 3)

    def shape(points, depth, bend):
        turn = np.arctan2(points[:, 1], points[:, 0])
        out = 1 + depth * np.cos(20 * points[:, 2])
        x, y, z = out * np.cos(turn), out * np.sin(turn), points[:, 2]
        if not bend:
            return np.stack([x, y, z], axis=1)
        angle, reach = z * np.pi / 2 / 6, 12 / np.pi
        return np.stack(
            [reach - (reach - x) * np.cos(angle), y, (reach - x) * np.sin(angle)], axis=1
        )

    straight = Pyramid.on(cage, shape(flat.vertices, 0.05, False))
    bent = Pyramid.on(cage, shape(flat.vertices, 0.05, True))
    missed = [
        np.sqrt(
            np.mean(
                (
                    straight.edited(1, bent.approximations[1], frames=frames).positions()
                    - bent.positions()
                )
                ** 2
            )
        )
        for frames in (True, False)
    ]
    assert missed[0] < 0.3 * missed[1]


def test_details_scaled():
    made = pyramid("cube", levels=3)
    smooth, strong = made.with_detail(0), made.with_detail(2.0)
    assert np.abs(smooth.positions() - made.positions(detail=0)).max() < 1e-14
    assert np.abs(strong.positions() + smooth.positions() - 2 * made.positions()).max() < 1e-13
    for changed in (smooth, strong, made.with_detail([1, 0.5, 0], frames=True)):
        assert np.abs(fresh(changed).approximations[0] - made.approximations[0]).max() < 1e-12
    without_finest = made.with_detail([1, 1, 0])
    assert np.abs(without_finest.positions() - made.positions(detail=2)).max() < 1e-13
    only = np.zeros(len(made.details[2]))
    only[7] = 1
    one = made.with_detail([1, 1, only])
    assert np.flatnonzero(one.details[2].any(axis=1)).tolist() == [7]
    assert error(made, made.with_detail([1, 1, np.ones(len(made.details[2]))], frames=True)) < 1e-12


def test_details_of_another_surface():
    rough, smooth = pyramid(levels=3, seed=1), pyramid(levels=3, seed=2).with_detail([1, 0, 0])
    both = smooth.with_detail_of(rough, 1, frames=False)
    assert error(both, smooth.with_detail_of(smooth, 1)) > 0.01
    assert np.abs(both.approximations[1] - smooth.approximations[1]).max() < 1e-13
    assert np.array_equal(both.details[2], rough.details[2])
    assert error(rough, rough.with_detail_of(rough)) < 1e-12
    turn = Rotation.from_rotvec([0.5, 1, -0.2]).as_matrix()
    turned = rough.edited(0, rough.approximations[0] @ turn.T)
    bare = turned.with_detail(0)
    assert error(bare.with_detail_of(rough), turned) < 1e-10
    assert error(smooth.with_detail_of(rough, 3), smooth) < 1e-13


def test_a_modelled_cage():
    cage = hk.read(real("cage/spot_control.obj"))
    flat = fine(cage, 2)
    rng = np.random.default_rng(0)
    mesh = PolygonMesh(flat.vertices + rng.normal(0, 0.01, flat.vertices.shape), flat.faces)
    made = Pyramid.of(mesh)
    assert made.surface(0).face_count == 180
    assert error(made, made.with_detail(1)) < 1e-15
    turn = Rotation.from_rotvec([1, 0.4, -0.2]).as_matrix()
    moved = made.edited(0, made.approximations[0] @ turn.T)
    assert np.abs(moved.positions() - made.positions() @ turn.T).max() < 1e-12


def test_progress_is_told_and_can_cancel():
    told = []
    Pyramid.of(fine(tetrahedron_cage(), 2), progress=lambda text, done: told.append(done))
    assert told[0] == 0
    assert told == sorted(told)
    assert told[-1] <= 1

    def cancel(text: str, done: float) -> None:
        if "analysing" in text:
            raise Cancelled("enough")

    with pytest.raises(Cancelled):
        Pyramid.of(fine(tetrahedron_cage(), 2), progress=cancel)


BAD = {
    "level": (lambda p: p.edited(3, p.positions()), "level must be a whole number from 0 to 2"),
    "negative": (lambda p: p.surface(-1), "level must be a whole number"),
    "detail": (lambda p: p.surface(0, 1), "level 0 can't show the detail of level 1"),
    "shape": (lambda p: p.edited(0, np.zeros((3, 3))), r"shape \(12, 3\), not \(3, 3\)"),
    "not finite": (lambda p: p.edited(0, np.full((12, 3), np.nan)), "rows 0, 1, .* are not"),
    "both": (lambda p: p.edited(0, [], displacement=[]), "either positions or a displacement"),
    "neither": (lambda p: p.edited(0), "either positions or a displacement"),
    "given": (lambda p: p.as_given(), "made on a cage"),
    "scale": (lambda p: p.with_detail([1]), "scale must be a number, or 2 of them"),
    "scales": (lambda p: p.with_detail([1, [1, 2]]), "scale of level 1 .* number or 120"),
    "text": (lambda p: p.with_detail("much"), "scale must be a number, or 2 of them"),
    "infinite": (lambda p: p.with_detail(np.inf), "scale of level 0 must be a finite number"),
    "others": (lambda p: p.with_detail_of(pyramid("cube")), "must have the same cage"),
    "levels": (lambda p: p.with_detail_of(pyramid(levels=3)), "must have the same cage"),
    "wavelets": (lambda p: p.with_detail_of(pyramid(support=1)), "must have the same cage"),
    "count": (lambda p: Pyramid.on(p.cage, np.zeros((20, 3))), "12, 42, 162 vertices"),
    "cage alone": (lambda p: Pyramid.on(p.cage, p.cage.vertices), "one level from 1 on"),
    "empty": (lambda p: Pyramid.on(p.cage, []), r"shape \(n, 3\), not \(0,\)"),
    "support": (lambda p: pyramid(support=-1), "support must be a whole number from 0"),
    "no wavelets": (lambda p: pyramid(support=1, interpolating=True), "takes no wavelets"),
    "refinement": (lambda p: Pyramid.on(p.cage, p.positions(), refinement="x"), "refinement must"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_is_said(name):
    make, words = BAD[name]
    with pytest.raises(InvalidInput, match=words):
        make(pyramid())


def test_surfaces_without_levels():
    with pytest.raises(Infeasible, match="does not come from refinement"):
        Pyramid.of(tetrahedron_cage())
    with pytest.raises(Infeasible, match="not from 3"):
        Pyramid.of(shapes.icosphere(2), 3)
    mesh = fine(torus_cage(4, 3), 1)
    with pytest.raises(NotFinite):
        Pyramid.of(PolygonMesh(mesh.vertices * np.nan, mesh.faces))
