// Flooding of a surface from seeds: each face joins the patch whose front reaches it with the least
// error (D. Cohen-Steiner, P. Alliez, M. Desbrun, "Variational shape approximation", 2004, Section
// 3.3: "distortion-minimizing flooding"). The error of a face is that of its normal (the metric
// L2,1) and, so that patches stay compact where normals agree, its distance from the patch's
// centre.
#include "kernels.hpp"

#include <algorithm>
#include <queue>

namespace henkei {
namespace {

struct Claim {
    double error;
    int32_t face, patch;
    // Of equal errors the lower face comes first, then the lower patch.
    bool operator<(const Claim& other) const {
        if (error != other.error) return error > other.error;
        if (face != other.face) return face > other.face;
        return patch > other.patch;
    }
};

double squared_distance(const double* a, const double* b) {
    const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z;
}

}  // namespace

void flood(const int32_t* neighbours, const double* normals, const double* centres, int64_t faces,
           const int32_t* seeds, const double* patch_normals, const double* patch_centres,
           int64_t patches, double compactness, int32_t* label) {
    std::fill(label, label + faces, -1);
    std::priority_queue<Claim> front;
    const auto claim_neighbours = [&](int32_t face, int32_t patch) {
        for (int side = 0; side < 3; ++side) {
            const int32_t next = neighbours[3 * face + side];
            if (next < 0 || label[next] >= 0) continue;
            const double error =
                squared_distance(normals + 3 * next, patch_normals + 3 * patch) +
                compactness * squared_distance(centres + 3 * next, patch_centres + 3 * patch);
            front.push({error, next, patch});
        }
    };
    for (int32_t patch = 0; patch < patches; ++patch) label[seeds[patch]] = patch;
    for (int32_t patch = 0; patch < patches; ++patch) claim_neighbours(seeds[patch], patch);
    for (int64_t taken = 0; !front.empty(); ++taken) {
        if (taken % 65536 == 0) check_interrupt();
        const Claim best = front.top();
        front.pop();
        if (label[best.face] >= 0) continue;
        label[best.face] = best.patch;
        claim_neighbours(best.face, best.patch);
    }
}

}  // namespace henkei
