// Gives the kernels to Python: numpy arrays in and out, the GIL released while they run.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include "kernels.hpp"
#include "overlay.hpp"

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

}  // namespace

NB_MODULE(_kernels, m) {
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
}
