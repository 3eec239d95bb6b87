// A sparse matrix by rows times an array of three columns, added to another.
#include "deformation.hpp"

namespace henkei {

void product(const SparseRows& rows, const double* right, const double* start, double* out) {
    for (int64_t i = 0; i < rows.count; ++i) {
        double x = 0, y = 0, z = 0;
        for (int32_t k = rows.start[i]; k < rows.start[i + 1]; ++k) {
            const double value = rows.values[k];
            const double* from = right + 3 * int64_t(rows.indices[k]);
            x += value * from[0];
            y += value * from[1];
            z += value * from[2];
        }
        if (start != nullptr) {
            x += start[3 * i];
            y += start[3 * i + 1];
            z += start[3 * i + 2];
        }
        out[3 * i] = x;
        out[3 * i + 1] = y;
        out[3 * i + 2] = z;
    }
}

}  // namespace henkei
