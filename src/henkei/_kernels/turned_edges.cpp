// The right side of the global step of smooth as-rigid-as-possible deformation: edges and curvature
// normals at rest, turned as their vertices are (D. Oehri, P. Herholz, O. Sorkine-Hornung, "Smooth
// as-rigid-as-possible deformation", 2025), less what they give at rest.
#include "deformation.hpp"

namespace henkei {
namespace {

struct Turn {
    double less_identity[9];

    Turn(const double* rotation, double scale) {
        for (int k = 0; k < 9; ++k) less_identity[k] = scale * rotation[k];
        for (int k = 0; k < 9; k += 4) less_identity[k] -= 1;
    }
    void add(const double* v, double* sum) const {
        const double* a = less_identity;
        sum[0] += a[0] * v[0] + a[1] * v[1] + a[2] * v[2];
        sum[1] += a[3] * v[0] + a[4] * v[1] + a[5] * v[2];
        sum[2] += a[6] * v[0] + a[7] * v[1] + a[8] * v[2];
    }
};

}  // namespace

void turned_edges(const SparseRows& weights, const double* rest, const double* normals,
                  const double* rotations, const double* scale, double* stretch, double* bent) {
    for (int64_t i = 0; i < weights.count; ++i) {
        const double *x = rest + 3 * i, *normal = normals + 3 * i;
        double all[3] = {0, 0, 0},
               sum[3] = {0, 0, 0};  // of the edges; of those turned at their ends
        for (int32_t k = weights.start[i]; k < weights.start[i + 1]; ++k) {
            const int64_t j = weights.indices[k];
            const double half = weights.values[k] / 2;
            const double edge[3] = {half * (x[0] - rest[3 * j]), half * (x[1] - rest[3 * j + 1]),
                                    half * (x[2] - rest[3 * j + 2])};
            for (int c = 0; c < 3; ++c) all[c] += edge[c];
            Turn(rotations + 9 * j, scale ? scale[j] : 1).add(edge, sum);
        }
        const Turn own(rotations + 9 * i, scale ? scale[i] : 1);
        own.add(all, sum);
        double turned[3] = {0, 0, 0};
        own.add(normal, turned);
        for (int c = 0; c < 3; ++c) {
            stretch[3 * i + c] = sum[c];
            bent[3 * i + c] = turned[c];
        }
    }
}

}  // namespace henkei
