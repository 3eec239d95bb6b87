// A sparse matrix by rows times an array of any number of columns, added to another.
#include "columns.hpp"
#include "deformation.hpp"

namespace henkei {

namespace {

template <int Width, int Stride>
void multiply(const SparseRows& rows, const double* right, int64_t columns, const double* start,
              double* out) {
    const int64_t stride = Stride ? Stride : columns;
    for (int64_t i = 0; i < rows.count; ++i) {
        double sum[Width] = {};
        for (int32_t k = rows.start[i]; k < rows.start[i + 1]; ++k) {
            const double value = rows.values[k];
            const double* from = right + stride * rows.indices[k];
            for (int c = 0; c < Width; ++c) sum[c] += value * from[c];
        }
        if (start != nullptr) {
            for (int c = 0; c < Width; ++c) sum[c] += start[stride * i + c];
        }
        for (int c = 0; c < Width; ++c) out[stride * i + c] = sum[c];
    }
}

}  // namespace

void product(const SparseRows& rows, const double* right, int64_t columns, const double* start,
             double* out) {
    in_columns(columns, [&](auto width, auto stride, int64_t first) {
        multiply<decltype(width)::value, decltype(stride)::value>(
            rows, right + first, columns, start == nullptr ? nullptr : start + first, out + first);
    });
}

}  // namespace henkei
