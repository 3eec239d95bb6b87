// Gives the kernels to Python: numpy arrays in and out, the GIL released while they run.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include "kernels.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace henkei {

void check_interrupt() {
    nb::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

}  // namespace henkei

namespace {

using henkei::half_edge_twins;

template <class T, ssize_t... Shape>
using In = nb::ndarray<const T, nb::numpy, nb::shape<Shape...>, nb::c_contig, nb::device::cpu>;
template <class T>
using Out = nb::ndarray<nb::numpy, T>;

// Hands a vector's memory over to numpy, as an array with `columns` columns (0: one-dimensional).
template <class T>
Out<T> hand_over(std::vector<T>&& data, size_t columns = 0) {
    auto* owned = new std::vector<T>(std::move(data));
    nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
    if (columns == 0) return Out<T>(owned->data(), {owned->size()}, owner);
    return Out<T>(owned->data(), {owned->size() / columns, columns}, owner);
}

}  // namespace

NB_MODULE(_kernels, m) {
    m.def(
        "half_edge_twins",
        [](In<int32_t, -1> origin, In<int32_t, -1> target, int64_t vertices) {
            std::vector<int32_t> twin(origin.size());
            {
                nb::gil_scoped_release release;
                half_edge_twins(origin.data(), target.data(), int64_t(origin.size()), vertices,
                                twin.data());
            }
            return hand_over(std::move(twin));
        },
        "origin"_a, "target"_a, "vertices"_a);
}
