// Gives the kernels to Python: numpy arrays in and out, the GIL released while they run.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>

#include <optional>
#include <string>

#include "cholesky.hpp"
#include "closest_points.hpp"
#include "deformation.hpp"
#include "design.hpp"
#include "kernels.hpp"
#include "motorcycles.hpp"
#include "ordering.hpp"
#include "overlay.hpp"
#include "quad_chords.hpp"
#include "quad_relaxation.hpp"
#include "remeshing.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace henkei {

void check_interrupt() {
    nb::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

}  // namespace henkei

namespace {

using henkei::Array;
using henkei::half_edge_twins;
using henkei::PlanePoint;
using henkei::Triangulation;

template <class T, ssize_t... Shape>
using In = nb::ndarray<const T, nb::numpy, nb::shape<Shape...>, nb::c_contig, nb::device::cpu>;
template <class T>
using Out = nb::ndarray<nb::numpy, T>;

// Hands an array's memory over to numpy, as an array with `columns` columns (0: one-dimensional).
template <class Vector>
auto hand_over(Vector&& data, size_t columns = 0) {
    using Result = Out<typename Vector::value_type>;
    auto* owned = new Vector(std::move(data));
    nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<Vector*>(p); });
    if (columns == 0) return Result(owned->data(), {owned->size()}, owner);
    return Result(owned->data(), {owned->size() / columns, columns}, owner);
}

static_assert(sizeof(PlanePoint) == 2 * sizeof(int64_t));

using Points = In<int64_t, -1, 2>;
using Faces = In<int32_t, -1, 3>;

const PlanePoint* plane_points(const Points& points) {
    return reinterpret_cast<const PlanePoint*>(points.data());
}

Triangulation triangulation(const Points& points, const Faces& faces,
                            const In<int32_t, -1>& twins) {
    return {plane_points(points), faces.data(), twins.data(), int64_t(points.shape(0)),
            int64_t(faces.shape(0))};
}

nb::dict overlay(Points points_a, Faces faces_a, In<int32_t, -1> twins_a, Points points_b,
                 Faces faces_b, In<int32_t, -1> twins_b, In<int32_t, -1, 2> boundary, int shift) {
    const Triangulation a = triangulation(points_a, faces_a, twins_a);
    const Triangulation b = triangulation(points_b, faces_b, twins_b);
    henkei::OverlayResult r;
    {
        nb::gil_scoped_release release;
        r = henkei::overlay(a, b, boundary.data(), int64_t(boundary.shape(0)), shift);
    }
    nb::dict d;
    d["crossings"] = r.crossings;
    d["faces"] = hand_over(std::move(r.faces), 3);
    d["face_a"] = hand_over(std::move(r.face_a));
    d["face_b"] = hand_over(std::move(r.face_b));
    d["node_of_b"] = hand_over(std::move(r.node_of_b));
    d["on_face_a"] = hand_over(std::move(r.on_face_a));
    d["on_face_b"] = hand_over(std::move(r.on_face_b));
    d["barycentric_a"] = hand_over(std::move(r.bary_a), 3);
    d["barycentric_b"] = hand_over(std::move(r.bary_b), 3);
    d["plane"] = hand_over(std::move(r.plane), 2);
    d["edges"] = hand_over(std::move(r.edges), 2);
    d["edge_a"] = hand_over(std::move(r.edge_a));
    d["edge_b"] = hand_over(std::move(r.edge_b));
    return d;
}

nb::tuple adapt(In<double, -1, 3> vertices, In<int64_t, -1> ring_start, In<int32_t, -1> ring,
                In<double, -1, 3> points, In<double, -1, 3> normals, In<int32_t, -1> winners,
                int64_t steps, double rate_start, double rate_end, double radius_start,
                double radius_end, bool literal, int64_t seed, In<double, 3> low,
                In<double, 3> high) {
    Array<double> x(vertices.data(), vertices.data() + vertices.size());
    int64_t without = 0;
    {
        nb::gil_scoped_release release;
        without =
            henkei::adapt(x.data(), int64_t(vertices.shape(0)), ring_start.data(), ring.data(),
                          points.data(), normals.data(), winners.data(), int64_t(points.shape(0)),
                          {steps, rate_start, rate_end, radius_start, radius_end, literal, seed},
                          low.data(), high.data());
    }
    return nb::make_tuple(hand_over(std::move(x), 3), without);
}

nb::tuple closest(const henkei::ClosestPoints& surface, In<double, -1, 3> points) {
    const size_t count = points.shape(0);
    Array<int32_t> face(count);
    Array<double> barycentric(3 * count), squared_distance(count);
    {
        nb::gil_scoped_release release;
        surface.query(points.data(), int64_t(count), face.data(), barycentric.data(),
                      squared_distance.data());
    }
    return nb::make_tuple(hand_over(std::move(face)), hand_over(std::move(barycentric), 3),
                          hand_over(std::move(squared_distance)));
}

using Vectors = In<double, -1, 3>;

const henkei::RefinementInput::Vec* vectors(const Vectors& array) {
    return reinterpret_cast<const henkei::RefinementInput::Vec*>(array.data());
}

nb::tuple locate_on_sphere(Vectors sphere, Faces faces, In<int32_t, -1> twins, Vectors points) {
    Array<int32_t> face(points.shape(0));
    Array<double> weights(points.size());
    {
        nb::gil_scoped_release release;
        henkei::locate_on_sphere(sphere.data(), faces.data(), twins.data(), int64_t(faces.shape(0)),
                                 points.data(), int64_t(points.shape(0)), face.data(),
                                 weights.data());
    }
    return nb::make_tuple(hand_over(std::move(face)), hand_over(std::move(weights), 3));
}

Out<double> refine(Vectors sphere, Vectors rest, Vectors guide, In<double, -1> trust, Faces faces,
                   In<uint8_t, -1> frozen, In<int32_t, -1> region, In<double, -1, -1> outside,
                   Vectors target_sphere, Vectors target, Vectors target_normals,
                   Faces target_faces, In<int32_t, -1> target_twins, Vectors control_sphere,
                   Vectors controls, In<double, 7> weights, int64_t coarsest, int sweeps,
                   nb::callable done, std::optional<nb::callable> seen) {
    Array<double> moved(sphere.size());
    const double* w = weights.data();
    henkei::RefinementInput in{};
    in.sphere = vectors(sphere), in.rest = vectors(rest), in.guide = vectors(guide);
    in.trust = trust.data(), in.outside = outside.data(), in.region = region.data();
    in.faces = faces.data(), in.frozen = frozen.data();
    in.vertices = int64_t(sphere.shape(0)), in.faces_count = int64_t(faces.shape(0));
    in.target_sphere = vectors(target_sphere), in.target_x = vectors(target);
    in.target_normals = vectors(target_normals);
    in.target_faces = target_faces.data(), in.target_twins = target_twins.data();
    in.target_face_count = int64_t(target_faces.shape(0));
    in.target_vertices = int64_t(target.shape(0));
    in.control_sphere = vectors(control_sphere), in.control_x = vectors(controls);
    in.controls = int64_t(controls.shape(0));
    henkei::RefinementReport report;
    report.done = [&](double share) {
        nb::gil_scoped_acquire gil;
        done(share);
    };
    const auto look = [&](const double* directions) {
        nb::gil_scoped_acquire gil;
        (*seen)(hand_over(Array<double>(directions, directions + sphere.size()), 3));
    };
    if (seen) report.seen = look;
    {
        nb::gil_scoped_release release;
        henkei::refine(in, {w[0], w[1], w[2], w[3], w[4], w[5], w[6]}, coarsest, sweeps, report,
                       moved.data());
    }
    return hand_over(std::move(moved), 3);
}

// The loops of a deformation write into their last arguments. What would cost them a copy in each
// frame, indices of another size, is refused.
using Numbers = In<double, -1>;
using Indices = In<int32_t, -1>;
template <class T, ssize_t... Shape>
using InOut = nb::ndarray<T, nb::numpy, nb::shape<Shape...>, nb::c_contig, nb::device::cpu>;
using VectorsOut = InOut<double, -1, 3>;

void require(bool agrees, const char* of) {
    if (!agrees) throw nb::value_error((std::string("arrays differ in their ") + of).c_str());
}

henkei::SparseRows rows_of(const Indices& start, const Indices& indices, const Numbers& values,
                           size_t count) {
    require(start.size() == count + 1, "number of rows");
    require(indices.size() == values.size() && size_t(start.data()[count]) == values.size(),
            "number of entries");
    return {start.data(), indices.data(), values.data(), int64_t(count)};
}

void turned_normals(In<double, -1, -1> weights, Vectors rotation_vectors, Numbers log_scales,
                    Vectors normals, VectorsOut out) {
    const size_t handles = weights.shape(1), count = out.shape(0);
    require(rotation_vectors.shape(0) == handles && log_scales.size() == handles, "handles");
    require(weights.shape(0) == count && normals.shape(0) == count, "vertices");
    nb::gil_scoped_release release;
    henkei::turned_normals(weights.data(), int64_t(handles), rotation_vectors.data(),
                           log_scales.data(), normals.data(), int64_t(count), out.data());
}

using Table = In<double, -1, -1>;
using TableOut = InOut<double, -1, -1>;

void product(Indices start, Indices indices, Numbers values, Table right, std::optional<Table> add,
             TableOut out) {
    const henkei::SparseRows rows = rows_of(start, indices, values, out.shape(0));
    require(!add || add->shape(0) == out.shape(0), "number of rows");
    require(right.shape(1) == out.shape(1) && (!add || add->shape(1) == out.shape(1)), "columns");
    nb::gil_scoped_release release;
    henkei::product(rows, right.data(), int64_t(out.shape(1)), add ? add->data() : nullptr,
                    out.data());
}

void fitted_rotations(Indices start, Indices indices, Numbers weights, Vectors rest,
                      Vectors displacement, Indices group,
                      std::optional<In<double, -1, 3, 3>> before, double follow,
                      InOut<double, -1, 3, 3> rotations) {
    const size_t count = rotations.shape(0);
    const henkei::SparseRows rows = rows_of(start, indices, weights, count);
    require(rest.shape(0) == count && displacement.shape(0) == count && group.size() == count &&
                (!before || before->shape(0) == count),
            "vertices");
    nb::gil_scoped_release release;
    henkei::fitted_rotations(rows, rest.data(), displacement.data(), group.data(),
                             before ? before->data() : nullptr, follow, rotations.data());
}

void turned_edges(Indices start, Indices indices, Numbers weights, Vectors rest, Vectors normals,
                  In<double, -1, 3, 3> rotations, std::optional<Numbers> scale, VectorsOut stretch,
                  VectorsOut bent) {
    const size_t count = stretch.shape(0);
    const henkei::SparseRows rows = rows_of(start, indices, weights, count);
    require(rest.shape(0) == count && normals.shape(0) == count && rotations.shape(0) == count &&
                (!scale || scale->size() == count) && bent.shape(0) == count,
            "vertices");
    nb::gil_scoped_release release;
    henkei::turned_edges(rows, rest.data(), normals.data(), rotations.data(),
                         scale ? scale->data() : nullptr, stretch.data(), bent.data());
}

template <class T>
void blended(In<T, -1, -1> basis, Numbers coefficients, Numbers start, InOut<double, -1> out) {
    const size_t terms = basis.shape(0), count = basis.shape(1);
    require(coefficients.size() == terms, "terms");
    require(start.size() == count && out.size() == count, "columns");
    nb::gil_scoped_release release;
    henkei::blended(basis.data(), coefficients.data(), int64_t(terms), start.data(), int64_t(count),
                    out.data());
}

void shifted(Vectors start, Numbers weight, In<double, 3> vector, VectorsOut out) {
    const size_t count = out.shape(0);
    require(start.shape(0) == count && weight.size() == count, "vertices");
    nb::gil_scoped_release release;
    henkei::shifted(start.data(), weight.data(), vector.data(), int64_t(count), out.data());
}

henkei::Pattern pattern_of(const Indices& start, const Indices& row) {
    require(start.size() > 0 && size_t(start.data()[start.size() - 1]) == row.size(),
            "number of entries");
    return {int32_t(start.size() - 1), start.data(), row.data()};
}

auto ordered(const Indices& start, const Indices& row,
             std::vector<int32_t> (*by)(const henkei::Pattern&)) {
    const henkei::Pattern pattern = pattern_of(start, row);
    std::vector<int32_t> order;
    {
        nb::gil_scoped_release release;
        order = by(pattern);
    }
    return hand_over(std::move(order));
}

void factor(henkei::Cholesky* self, Indices start, Indices row, Numbers values, Indices order) {
    const henkei::Pattern pattern = pattern_of(start, row);
    require(values.size() == row.size(), "number of entries");
    require(int64_t(order.size()) == pattern.size, "number of unknowns");
    nb::gil_scoped_release release;
    new (self) henkei::Cholesky(pattern, values.data(), order.data());
}

void solve(const henkei::Cholesky& cholesky, In<double, -1, -1> right, InOut<double, -1, -1> out) {
    require(int64_t(right.shape(0)) == cholesky.size() && out.shape(0) == right.shape(0),
            "number of unknowns");
    require(right.shape(1) == out.shape(1), "columns");
    nb::gil_scoped_release release;
    cholesky.solve(right.data(), out.data(), int64_t(right.shape(1)));
}

template <class T>
std::vector<T> copied(const In<T, -1>& values) {
    return {values.data(), values.data() + values.shape(0)};
}

template <class T, ssize_t Columns>
std::vector<T> copied(const In<T, -1, Columns>& values) {
    return {values.data(), values.data() + values.shape(0) * Columns};
}

nb::dict trace_motorcycles(In<double, -1, 3> vertices, Faces faces, In<int32_t, -1> twin,
                           In<double, -1, 2> change, In<int8_t, -1> matching, In<int8_t, -1> track,
                           In<uint8_t, -1> feature, In<uint8_t, -1> kept_off,
                           In<int32_t, -1, 2> starts, double meeting) {
    henkei::TracingResult r;
    {
        henkei::TracedSurface s{copied(vertices), copied(faces), copied(twin),    copied(change),
                                copied(matching), copied(track), copied(feature), copied(kept_off)};
        nb::gil_scoped_release release;
        r = henkei::trace_motorcycles(std::move(s), starts.data(), int64_t(starts.shape(0)),
                                      meeting);
    }
    nb::dict d;
    d["vertices"] = hand_over(std::move(r.surface.vertices), 3);
    d["faces"] = hand_over(std::move(r.surface.faces), 3);
    d["twin"] = hand_over(std::move(r.surface.twin));
    d["change"] = hand_over(std::move(r.surface.change), 2);
    d["matching"] = hand_over(std::move(r.surface.matching));
    d["track"] = hand_over(std::move(r.surface.track));
    d["feature"] = hand_over(std::move(r.surface.feature));
    d["kept_off"] = hand_over(std::move(r.surface.kept_off));
    d["turn"] = hand_over(std::move(r.turn));
    d["motorcycles"] = r.motorcycles;
    d["merged"] = r.merged;
    d["lost"] = r.lost;
    return d;
}

void remeshing(henkei::Remeshing* self, Vectors vertices, Faces faces, In<int32_t, -1> twins,
               In<uint8_t, -1> feature, Numbers length) {
    require(length.size() == vertices.shape(0), "vertices");
    require(twins.size() == faces.size() && feature.size() == faces.size(), "half-edges");
    nb::gil_scoped_release release;
    new (self)
        henkei::Remeshing({vectors(vertices), faces.data(), twins.data(), feature.data(),
                           length.data(), int64_t(vertices.shape(0)), int64_t(faces.shape(0))});
}

nb::tuple remeshed(const henkei::Remeshing& self) {
    henkei::Remeshing::Result r = self.result();
    return nb::make_tuple(hand_over(std::move(r.faces), 3), hand_over(std::move(r.feature)),
                          hand_over(std::move(r.on_face)), hand_over(std::move(r.weights), 3),
                          hand_over(std::move(r.corner)));
}

nb::tuple collapse_chords(Vectors points, Numbers sizes, In<int32_t, -1, 4> quads,
                          In<int32_t, -1> twin, In<int32_t, -1> feature, In<int32_t, -1> rank,
                          In<int32_t, -1> wished, int64_t target) {
    const size_t count = points.shape(0);
    require(sizes.size() == count && rank.size() == count && wished.size() == count, "vertices");
    require(twin.size() == quads.size() && feature.size() == quads.size(), "half-edges");
    henkei::QuadsWithSizes mesh{
        {},           copied(sizes), copied(quads), copied(twin), copied(feature),
        copied(rank), copied(wished)};
    mesh.points.assign(vectors(points), vectors(points) + count);
    henkei::CollapsedQuads r;
    {
        nb::gil_scoped_release release;
        r = henkei::collapse_chords(std::move(mesh), target);
    }
    return nb::make_tuple(hand_over(std::move(r.points), 3), hand_over(std::move(r.quads), 4),
                          hand_over(std::move(r.numbers)), hand_over(std::move(r.feature), 4),
                          r.chords);
}

// The relaxation of quads.
void relaxation(henkei::QuadRelaxation* self, Vectors vertices, Faces faces, Indices twins,
                In<int64_t, -1> line_start, Vectors line_points, Numbers line_arc,
                Indices line_half_edges, In<uint8_t, -1> line_closed, In<int32_t, -1, 4> quads,
                Indices face, Vectors weights, Vectors points, In<uint8_t, -1> held, Indices line,
                Numbers arc, In<int32_t, -1, 2> beside, In<double, -1, 2> limits, Numbers size,
                Indices centre) {
    const size_t count = points.shape(0);
    require(face.size() == count && weights.shape(0) == count && held.size() == count &&
                line.size() == count && arc.size() == count && beside.shape(0) == count &&
                limits.shape(0) == count && size.size() == count,
            "vertices");
    require(centre.size() == quads.shape(0), "quads");
    require(twins.size() == faces.size(), "half-edges");
    require(line_closed.size() + 1 == line_start.size() &&
                line_points.shape(0) == line_arc.size() &&
                line_half_edges.size() == line_arc.size(),
            "points of lines");
    henkei::QuadLines lines{
        copied(line_start), {}, copied(line_arc), copied(line_half_edges), copied(line_closed)};
    for (size_t i = 0; i < line_points.shape(0); ++i) {
        lines.point.push_back({line_points(i, 0), line_points(i, 1), line_points(i, 2)});
    }
    nb::gil_scoped_release release;
    new (self) henkei::QuadRelaxation(
        henkei::SurfacePlaces(vertices.data(), int64_t(vertices.shape(0)), faces.data(),
                              twins.data(), int64_t(faces.shape(0))),
        henkei::ClosestPoints(vertices.data(), faces.data(), int64_t(faces.shape(0))),
        std::move(lines), copied(quads), face.data(), weights.data(), points.data(), int64_t(count),
        copied(held), line.data(), arc.data(), beside.data(), limits.data(), copied(size),
        centre.data());
}

nb::tuple relaxation_result(const henkei::QuadRelaxation& self) {
    const size_t count = size_t(self.vertex_count());
    std::vector<double> points(3 * count), weights(3 * count);
    std::vector<int32_t> face(count);
    self.result(points.data(), face.data(), weights.data());
    return nb::make_tuple(hand_over(std::move(points), 3), hand_over(std::move(face)),
                          hand_over(std::move(weights), 3));
}

auto relaxation_quality(henkei::QuadRelaxation& self) {
    std::vector<double> quality(size_t(self.quad_count()));
    {
        nb::gil_scoped_release release;
        self.quality(quality.data());
    }
    return hand_over(std::move(quality));
}

// The design on a subdivided cage.
using Edges = In<int32_t, -1, 2>;

nb::tuple smoothing_neighbours(int64_t vertices, Edges edges, Indices corner_edges) {
    henkei::VertexRows rows;
    {
        nb::gil_scoped_release release;
        rows = henkei::smoothing_neighbours(vertices, edges.data(), int64_t(edges.shape(0)),
                                            corner_edges.data(), int64_t(corner_edges.size()));
    }
    return nb::make_tuple(hand_over(std::move(rows.start)), hand_over(std::move(rows.indices)));
}

void smoothed(Indices start, Indices neighbours, Table values, Numbers factors,
              std::optional<In<uint8_t, -1>> free, TableOut out) {
    const size_t count = out.shape(0);
    require(
        start.size() == count + 1 && values.shape(0) == count && (!free || free->size() == count),
        "vertices");
    require(size_t(start.data()[count]) == neighbours.size(), "number of neighbours");
    require(values.shape(1) == out.shape(1) && factors.size() == out.shape(1), "columns");
    if (values.data() == out.data() && count > 0) throw nb::value_error("values and out are one");
    nb::gil_scoped_release release;
    henkei::smoothed(start.data(), neighbours.data(), int64_t(count), values.data(),
                     int64_t(out.shape(1)), factors.data(), free ? free->data() : nullptr,
                     out.data());
}

nb::tuple hat_products(int64_t vertices, Indices indices, int corners, double area) {
    if (corners != 3 && corners != 4) throw nb::value_error("corners may be 3 or 4");
    require(indices.size() % size_t(corners) == 0, "corners a face");
    henkei::HatProducts r;
    {
        nb::gil_scoped_release release;
        r = henkei::hat_products(vertices, indices.data(), int64_t(indices.size()) / corners,
                                 corners, area);
    }
    return nb::make_tuple(hand_over(std::move(r.start)), hand_over(std::move(r.indices)),
                          hand_over(std::move(r.values)));
}

henkei::CageView cage_view(int64_t vertices, const Indices& indices, const Edges& edges,
                           const Indices& corner_edges) {
    require(indices.size() == corner_edges.size(), "corners");
    return {vertices,
            indices.data(),
            edges.data(),
            corner_edges.data(),
            int64_t(indices.size()),
            int64_t(edges.shape(0))};
}

// Checks how many rows the coarser level and the finer one have, each with so many columns.
template <class Coarse, class Fine>
void require_levels(const henkei::CageView& view, int sides, const Coarse& coarse,
                    const Fine& fine) {
    if (sides != 3 && sides != 4) throw nb::value_error("sides may be 3 or 4");
    require(view.corners % sides == 0, "corners a face");
    const int64_t centres = sides == 4 ? view.corners / 4 : 0;
    require(int64_t(coarse.shape(0)) == view.vertices, "vertices of the coarser level");
    require(int64_t(fine.shape(0)) == view.vertices + view.edge_count + centres,
            "vertices of the finer level");
    require(coarse.shape(1) == fine.shape(1), "columns");
}

void restricted(int64_t vertices, Indices indices, Edges edges, Indices corner_edges, int sides,
                double area, Table values, TableOut out) {
    const henkei::CageView coarse = cage_view(vertices, indices, edges, corner_edges);
    require_levels(coarse, sides, out, values);
    nb::gil_scoped_release release;
    henkei::restricted(coarse, sides, area, values.data(), int64_t(out.shape(1)), out.data());
}

void add_corrected(int64_t vertices, Indices indices, Edges edges, Indices corner_edges, int sides,
                   double area, Table hats, std::optional<In<uint8_t, -1>> free, TableOut out) {
    const henkei::CageView coarse = cage_view(vertices, indices, edges, corner_edges);
    require_levels(coarse, sides, hats, out);
    require(!free || free->size() == out.shape(0), "vertices");
    nb::gil_scoped_release release;
    henkei::add_corrected(coarse, sides, area, hats.data(), int64_t(out.shape(1)),
                          free ? free->data() : nullptr, out.data());
}

nb::tuple handed_over(henkei::RefinedFaces&& r) {
    return nb::make_tuple(hand_over(std::move(r.indices)), hand_over(std::move(r.edges), 2),
                          hand_over(std::move(r.corner_edges)));
}

nb::tuple refined_triangles(int64_t vertices, Indices indices, Edges edges, Indices corner_edges) {
    const henkei::CageView cage = cage_view(vertices, indices, edges, corner_edges);
    require(indices.size() % 3 == 0, "corners a face");
    henkei::RefinedFaces r;
    {
        nb::gil_scoped_release release;
        r = henkei::refined_triangles(cage);
    }
    return handed_over(std::move(r));
}

int64_t face_count(const In<int64_t, -1>& offsets, const Indices& indices) {
    const size_t faces = offsets.size() - 1;
    require(offsets.size() > 0 && size_t(offsets.data()[faces]) == indices.size(), "corners");
    return int64_t(faces);
}

nb::tuple refined_quads(int64_t vertices, Indices indices, In<int64_t, -1> offsets, Edges edges,
                        Indices corner_edges) {
    const henkei::CageView cage = cage_view(vertices, indices, edges, corner_edges);
    const int64_t faces = face_count(offsets, indices);
    henkei::RefinedFaces r;
    {
        nb::gil_scoped_release release;
        r = henkei::refined_quads(cage, offsets.data(), faces);
    }
    return handed_over(std::move(r));
}

Out<double> refined_vertices(Table values, Edges edges, Indices indices, In<int64_t, -1> offsets) {
    const int64_t faces = face_count(offsets, indices);
    const size_t columns = values.shape(1);
    const henkei::CageView cage{
        int64_t(values.shape(0)), indices.data(),         edges.data(), nullptr,
        int64_t(indices.size()),  int64_t(edges.shape(0))};
    henkei::Unfilled<double> out((values.shape(0) + edges.shape(0) + size_t(faces)) * columns);
    {
        nb::gil_scoped_release release;
        henkei::refined_vertices(cage, offsets.data(), faces, values.data(), int64_t(columns),
                                 out.data());
    }
    return hand_over(std::move(out), columns);
}

nb::tuple dual_columns(Indices start, Indices indices, Numbers values, Indices products_start,
                       Indices products_indices, Numbers products) {
    require(start.size() > 0 && products_start.size() > 0, "number of rows");
    const henkei::SparseRows rows = rows_of(start, indices, values, start.size() - 1);
    const henkei::SparseRows matrix =
        rows_of(products_start, products_indices, products, products_start.size() - 1);
    henkei::SparseColumns r;
    {
        nb::gil_scoped_release release;
        r = henkei::dual_columns(rows, matrix);
    }
    return nb::make_tuple(hand_over(std::move(r.start)), hand_over(std::move(r.indices)),
                          hand_over(std::move(r.values)));
}

}  // namespace

NB_MODULE(_kernels, m) {
    nb::class_<henkei::ClosestPoints>(m, "ClosestPoints")
        .def(
            "__init__",
            [](henkei::ClosestPoints* self, In<double, -1, 3> vertices, Faces faces) {
                nb::gil_scoped_release release;
                new (self)
                    henkei::ClosestPoints(vertices.data(), faces.data(), int64_t(faces.shape(0)));
            },
            "vertices"_a, "faces"_a)
        .def("query", &closest, "points"_a);
    nb::class_<henkei::Cholesky>(m, "Cholesky")
        .def("__init__", &factor, "start"_a, "row"_a, "values"_a, "order"_a)
        .def("solve", &solve, "right"_a, "out"_a)
        .def_prop_ro("entries", &henkei::Cholesky::entries);
    const nb::call_guard<nb::gil_scoped_release> free;
    nb::class_<henkei::Remeshing>(m, "Remeshing")
        .def("__init__", &remeshing, "vertices"_a, "faces"_a, "twins"_a, "feature"_a, "length"_a)
        .def("split_long", &henkei::Remeshing::split_long, "most"_a, free)
        .def("collapse_short", &henkei::Remeshing::collapse_short, free)
        .def("flip", &henkei::Remeshing::flip, free)
        .def("relax", &henkei::Remeshing::relax, free)
        .def("separate", &henkei::Remeshing::separate, free)
        .def("result", &remeshed);
    m.def(
        "minimum_degree",
        [](Indices start, Indices row) { return ordered(start, row, henkei::minimum_degree); },
        "start"_a, "row"_a);
    m.def(
        "nested_dissection",
        [](Indices start, Indices row) { return ordered(start, row, henkei::nested_dissection); },
        "start"_a, "row"_a);
    m.def(
        "half_edge_twins",
        [](In<int32_t, -1> origin, In<int32_t, -1> target, int64_t vertices) {
            Array<int32_t> twin(origin.size());
            {
                nb::gil_scoped_release release;
                half_edge_twins(origin.data(), target.data(), int64_t(origin.size()), vertices,
                                twin.data());
            }
            return hand_over(std::move(twin));
        },
        "origin"_a, "target"_a, "vertices"_a);
    m.def("overlay", &overlay, "points_a"_a, "faces_a"_a, "twins_a"_a, "points_b"_a, "faces_b"_a,
          "twins_b"_a, "boundary"_a, "shift"_a);
    m.def(
        "not_positive",
        [](Points points, Faces triangles) {
            Array<int32_t> bad;
            {
                nb::gil_scoped_release release;
                bad = henkei::not_positive(plane_points(points), triangles.data(),
                                           int64_t(triangles.shape(0)));
            }
            return hand_over(std::move(bad));
        },
        "points"_a, "triangles"_a);
    m.def(
        "self_intersections",
        [](In<double, -1, 3> vertices, In<int32_t, -1, 3> faces, int64_t limit) {
            std::vector<int32_t> pairs;
            {
                nb::gil_scoped_release release;
                pairs = henkei::self_intersections(vertices.data(), int64_t(vertices.shape(0)),
                                                   faces.data(), int64_t(faces.shape(0)), limit);
            }
            return hand_over(std::move(pairs), 2);
        },
        "vertices"_a, "faces"_a, "limit"_a);
    m.def(
        "embed_sphere",
        [](In<double, -1, 3> vertices, Faces faces, In<int32_t, -1> twins,
           In<double, -1, 3> desired, double area_weight, int sweeps) {
            std::vector<double> positions;
            {
                nb::gil_scoped_release release;
                positions = henkei::embed_sphere(
                    vertices.data(), int64_t(vertices.shape(0)), faces.data(), twins.data(),
                    int64_t(faces.shape(0)), desired.shape(0) ? desired.data() : nullptr,
                    area_weight, sweeps);
            }
            return hand_over(std::move(positions), 3);
        },
        "vertices"_a, "faces"_a, "twins"_a, "desired"_a, "area_weight"_a, "sweeps"_a);
    m.def(
        "inverted_on_sphere",
        [](In<double, -1, 3> positions, Faces faces) {
            std::vector<int32_t> bad;
            {
                nb::gil_scoped_release release;
                bad = henkei::inverted_on_sphere(positions.data(), faces.data(),
                                                 int64_t(faces.shape(0)));
            }
            return hand_over(std::move(bad));
        },
        "positions"_a, "faces"_a);
    m.def(
        "flood",
        [](Faces neighbours, In<double, -1, 3> normals, In<double, -1, 3> centres,
           In<int32_t, -1> seeds, In<double, -1, 3> patch_normals, In<double, -1, 3> patch_centres,
           double compactness) {
            Array<int32_t> label(neighbours.shape(0));
            {
                nb::gil_scoped_release release;
                henkei::flood(neighbours.data(), normals.data(), centres.data(),
                              int64_t(neighbours.shape(0)), seeds.data(), patch_normals.data(),
                              patch_centres.data(), int64_t(seeds.shape(0)), compactness,
                              label.data());
            }
            return hand_over(std::move(label));
        },
        "neighbours"_a, "normals"_a, "centres"_a, "seeds"_a, "patch_normals"_a, "patch_centres"_a,
        "compactness"_a);
    m.def("locate_on_sphere", &locate_on_sphere, "sphere"_a, "faces"_a, "twins"_a, "points"_a);
    m.def("refine", &refine, "sphere"_a, "rest"_a, "guide"_a, "trust"_a, "faces"_a, "frozen"_a,
          "region"_a, "outside"_a, "target_sphere"_a, "target"_a, "target_normals"_a,
          "target_faces"_a, "target_twins"_a, "control_sphere"_a, "controls"_a, "weights"_a,
          "coarsest"_a, "sweeps"_a, "done"_a, "seen"_a);
    m.def("adapt", &adapt, "vertices"_a, "ring_start"_a, "ring"_a, "points"_a, "normals"_a,
          "winners"_a, "steps"_a, "rate_start"_a, "rate_end"_a, "radius_start"_a, "radius_end"_a,
          "literal"_a, "seed"_a, "low"_a, "high"_a);
    m.def("turned_normals", &turned_normals, "weights"_a, "rotation_vectors"_a, "log_scales"_a,
          "normals"_a, "out"_a.noconvert());
    m.def("product", &product, "start"_a.noconvert(), "indices"_a.noconvert(), "values"_a,
          "right"_a, "add"_a.none(), "out"_a.noconvert());
    m.def("fitted_rotations", &fitted_rotations, "start"_a.noconvert(), "indices"_a.noconvert(),
          "weights"_a, "rest"_a, "displacement"_a, "group"_a.noconvert(), "before"_a.none(),
          "follow"_a, "rotations"_a.noconvert());
    m.def("turned_edges", &turned_edges, "start"_a.noconvert(), "indices"_a.noconvert(),
          "weights"_a, "rest"_a, "normals"_a, "rotations"_a, "scale"_a.none(),
          "stretch"_a.noconvert(), "bent"_a.noconvert());
    m.def("blended", &blended<double>, "basis"_a.noconvert(), "coefficients"_a, "start"_a,
          "out"_a.noconvert());
    m.def("blended", &blended<float>, "basis"_a.noconvert(), "coefficients"_a, "start"_a,
          "out"_a.noconvert());
    m.def("shifted", &shifted, "start"_a, "weight"_a, "vector"_a, "out"_a.noconvert());
    m.def("trace_motorcycles", &trace_motorcycles, "vertices"_a, "faces"_a, "twin"_a, "change"_a,
          "matching"_a, "track"_a, "feature"_a, "kept_off"_a, "starts"_a, "meeting"_a);
    m.def("refined_triangles", &refined_triangles, "vertex_count"_a, "indices"_a.noconvert(),
          "edges"_a.noconvert(), "corner_edges"_a.noconvert());
    m.def("refined_quads", &refined_quads, "vertex_count"_a, "indices"_a.noconvert(), "offsets"_a,
          "edges"_a.noconvert(), "corner_edges"_a.noconvert());
    m.def("refined_vertices", &refined_vertices, "values"_a, "edges"_a.noconvert(),
          "indices"_a.noconvert(), "offsets"_a);
    m.def("smoothing_neighbours", &smoothing_neighbours, "vertex_count"_a, "edges"_a,
          "corner_edges"_a);
    m.def("smoothed", &smoothed, "start"_a.noconvert(), "neighbours"_a.noconvert(), "values"_a,
          "factors"_a, "free"_a.none(), "out"_a.noconvert());
    m.def("hat_products", &hat_products, "vertex_count"_a, "indices"_a.noconvert(), "corners"_a,
          "area"_a);
    m.def("restricted", &restricted, "vertex_count"_a, "indices"_a.noconvert(),
          "edges"_a.noconvert(), "corner_edges"_a.noconvert(), "sides"_a, "area"_a, "values"_a,
          "out"_a.noconvert());
    m.def("add_corrected", &add_corrected, "vertex_count"_a, "indices"_a.noconvert(),
          "edges"_a.noconvert(), "corner_edges"_a.noconvert(), "sides"_a, "area"_a, "hats"_a,
          "free"_a.none(), "out"_a.noconvert());
    m.def("dual_columns", &dual_columns, "start"_a, "indices"_a, "values"_a,
          "products_start"_a.noconvert(), "products_indices"_a.noconvert(), "products"_a);
    m.def("collapse_chords", &collapse_chords, "points"_a, "sizes"_a, "quads"_a, "twin"_a,
          "feature"_a, "rank"_a, "wished"_a, "target"_a);
    using Release = nb::call_guard<nb::gil_scoped_release>;
    nb::class_<henkei::QuadRelaxation>(m, "QuadRelaxation")
        .def("__init__", &relaxation, "vertices"_a, "faces"_a, "twins"_a, "line_start"_a,
             "line_points"_a, "line_arc"_a, "line_half_edges"_a, "line_closed"_a, "quads"_a,
             "face"_a, "weights"_a, "points"_a, "held"_a, "line"_a, "arc"_a, "beside"_a, "limits"_a,
             "size"_a, "centre"_a)
        .def("fit", &henkei::QuadRelaxation::fit, "iterations"_a, "evenness"_a, Release())
        .def("improve", &henkei::QuadRelaxation::improve, "sweeps"_a, "power"_a, "stretch"_a,
             "evenness"_a, Release())
        .def("untangle", &henkei::QuadRelaxation::untangle, "sweeps"_a, "floor"_a, "seed"_a,
             Release())
        .def(
            "pin",
            [](henkei::QuadRelaxation& self, Indices vertices, Indices face, Vectors weights) {
                require(vertices.size() == face.size() && face.size() == weights.shape(0),
                        "number of places");
                self.pin(vertices.data(), face.data(), weights.data(), int64_t(vertices.size()));
            },
            "vertices"_a, "face"_a, "weights"_a)
        .def("mend", &henkei::QuadRelaxation::mend, "tries"_a, "seed"_a, Release())
        .def("save", &henkei::QuadRelaxation::save, "slot"_a)
        .def("restore", &henkei::QuadRelaxation::restore, "slot"_a)
        .def("quality", &relaxation_quality)
        .def("result", &relaxation_result);
}
