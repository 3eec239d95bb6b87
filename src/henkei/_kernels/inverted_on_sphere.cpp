// Faces of a map onto the sphere that do not run counter-clockwise seen from outside, decided
// exactly: the sign of det(a, b, c), from floating point where its error bound allows, else from
// expansions (see expansion.hpp).
// Exact where coordinates are 0 or at most 1 and at least 2^-248 in size.
#include <cmath>

#include "expansion.hpp"
#include "kernels.hpp"
#include "sphere.hpp"

namespace henkei {
namespace {

constexpr double kBound = 16 * kEpsilon;

bool surely_positive(const Vec& a, const Vec& b, const Vec& c) {
    const Vec ab = b - a, ac = c - a;
    double det = 0, size = 0;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double left = ab[j] * ac[k], right = ab[k] * ac[j];
        det += a[i] * (left - right);
        size += std::abs(a[i]) * (std::abs(left) + std::abs(right));
    }
    return det > kBound * size;
}

bool exactly_positive(const Vec& a, const Vec& b, const Vec& c) {
    Expansion total;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        Expansion pair, by;
        by.add(a[i]);
        const double left = b[j] * c[k], right = b[k] * c[j];
        pair.add(std::fma(b[j], c[k], -left));
        pair.add(left);
        pair.add(-std::fma(b[k], c[j], -right));
        pair.add(-right);
        total.add_product(pair, by, 1);
    }
    return total.sign() > 0;
}

bool finite(const Vec& a) {
    return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

}  // namespace

std::vector<int32_t> inverted_on_sphere(const double* positions, const int32_t* faces,
                                        int64_t face_count) {
    std::vector<int32_t> bad;
    for (int64_t f = 0; f < face_count; ++f) {
        Vec p[3];
        for (int k = 0; k < 3; ++k) {
            const double* x = positions + 3 * int64_t(faces[3 * f + k]);
            p[k] = {x[0], x[1], x[2]};
        }
        if (surely_positive(p[0], p[1], p[2])) continue;
        if (!finite(p[0]) || !finite(p[1]) || !finite(p[2]) ||
            !exactly_positive(p[0], p[1], p[2])) {
            bad.push_back(int32_t(f));
        }
    }
    return bad;
}

}  // namespace henkei
