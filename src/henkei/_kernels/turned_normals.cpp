// Curvature normals, turned and scaled as a field says (H. Masuda, Y. Yoshioka, Y. Furukawa,
// "Feature-preserving interactive mesh deformation", 2006, eq. 6, 8-11), less what they were.
// Rotations go by the quaternion (w, v): R n - n = 2 v x (v x n + w n), without cancellation for
// small angles. Half the angle is reduced to [-pi/2, pi/2] by multiples of pi, which only changes
// the sign of the quaternion; there, Taylor polynomials of sine and cosine are exact to rounding.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "deformation.hpp"
#include "vectorised.hpp"

namespace henkei {
namespace {

constexpr int kBlock = 128;  // vertices at a time, coordinate by coordinate

constexpr double kInversePi = 0.31830988618379067154;
// pi and log 2 in parts, the first ones so short that small multiples are exact
constexpr double kPi[3] = {0x1.921fb544p+1, 0x1.0b4611a6p-33, 0x1.3198a2e037073p-68};
constexpr double kInverseLog2 = 1.44269504088896340736;
constexpr double kLog2[2] = {0x1.62e42feep-1, 0x1.a39ef35793c76p-33};
constexpr double kRounder = 0x1.8p+52;  // adding and subtracting it rounds to an integer
constexpr double kLargestLogarithm = 700;

// The sum of a_k x^k.
template <int N>
inline double polynomial(const double (&a)[N], double x) {
    double sum = a[N - 1];
    for (int k = N - 2; k >= 0; --k) sum = sum * x + a[k];
    return sum;
}

// Taylor coefficients: sin(r)/r and cos(r) in r^2, (exp(r) - 1)/r in r.
constexpr double kSine[] = {1.0,
                            -1.0 / 6,
                            1.0 / 120,
                            -1.0 / 5040,
                            1.0 / 362880,
                            -1.0 / 39916800,
                            1.0 / 6227020800,
                            -1.0 / 1307674368000,
                            1.0 / 355687428096000,
                            -1.0 / 121645100408832000,
                            1.0 / 51090942171709440000.0};
constexpr double kCosine[] = {1.0,
                              -1.0 / 2,
                              1.0 / 24,
                              -1.0 / 720,
                              1.0 / 40320,
                              -1.0 / 3628800,
                              1.0 / 479001600,
                              -1.0 / 87178291200,
                              1.0 / 20922789888000,
                              -1.0 / 6402373705728000,
                              1.0 / 2432902008176640000.0};
constexpr double kExponential[] = {1.0,
                                   1.0 / 2,
                                   1.0 / 6,
                                   1.0 / 24,
                                   1.0 / 120,
                                   1.0 / 720,
                                   1.0 / 5040,
                                   1.0 / 40320,
                                   1.0 / 362880,
                                   1.0 / 3628800,
                                   1.0 / 39916800,
                                   1.0 / 479001600,
                                   1.0 / 6227020800,
                                   1.0 / 87178291200};

struct Block {
    double x[kBlock], y[kBlock], z[kBlock];  // rotation vectors
    double growth[kBlock];                   // logarithms of scales, then scales less 1
};

inline double exponential_less_1(double logarithm) {
    logarithm = logarithm < kLargestLogarithm ? logarithm : kLargestLogarithm;
    logarithm = logarithm > -kLargestLogarithm ? logarithm : -kLargestLogarithm;
    const double shifted = logarithm * kInverseLog2 + kRounder, k = shifted - kRounder;
    const double r = logarithm - k * kLog2[0] - k * kLog2[1];
    uint64_t bits;
    std::memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + 1023) << 52;  // the low bits of `shifted` are k
    double power;
    std::memcpy(&power, &bits, sizeof power);
    return power * (r * polynomial(kExponential, r)) + (power - 1);
}

// sums of weighted rotation vectors and logarithms
inline void sum_up(const double* weights, int64_t handles, const double* vectors,
                   const double* log_scales, int count, Block& block) {
    std::memset(&block, 0, sizeof block);
    for (int64_t h = 0; h < handles; ++h) {
        const double x = vectors[3 * h], y = vectors[3 * h + 1], z = vectors[3 * h + 2];
        const double logarithm = log_scales[h];
        for (int i = 0; i < count; ++i) {
            const double weight = weights[i * handles + h];
            block.x[i] += weight * x;
            block.y[i] += weight * y;
            block.z[i] += weight * z;
            block.growth[i] += weight * logarithm;
        }
    }
}

inline void turn(const Block& block, const double* normals, int count, double* out) {
    for (int i = 0; i < count; ++i) {
        const double x = block.x[i], y = block.y[i], z = block.z[i];
        const double angle = std::sqrt(x * x + y * y + z * z), half = angle / 2;
        const double k = (half * kInversePi + kRounder) - kRounder;
        const double r = half - k * kPi[0] - k * kPi[1] - k * kPi[2];
        const double w = polynomial(kCosine, r * r), sine = polynomial(kSine, r * r);
        const double part = k == 0 ? 0.5 : r / angle;
        const double factor = part * sine;
        const double a = factor * x, b = factor * y, c = factor * z;
        const double nx = normals[3 * i], ny = normals[3 * i + 1], nz = normals[3 * i + 2];
        const double tx = b * nz - c * ny + w * nx;
        const double ty = c * nx - a * nz + w * ny;
        const double tz = a * ny - b * nx + w * nz;
        const double dx = 2 * (b * tz - c * ty);
        const double dy = 2 * (c * tx - a * tz);
        const double dz = 2 * (a * ty - b * tx);
        const double growth = block.growth[i];
        out[3 * i] = dx + growth * (nx + dx);
        out[3 * i + 1] = dy + growth * (ny + dy);
        out[3 * i + 2] = dz + growth * (nz + dz);
    }
}

}  // namespace

HENKEI_VECTORISED
void turned_normals(const double* weights, int64_t handles, const double* rotation_vectors,
                    const double* log_scales, const double* normals, int64_t count, double* out) {
    bool turns = false, grows = false;
    for (int64_t h = 0; h < handles; ++h) {
        for (int k = 0; k < 3; ++k) turns |= rotation_vectors[3 * h + k] != 0;
        grows |= log_scales[h] != 0;
    }
    if (!turns && !grows) {
        std::fill(out, out + 3 * count, 0.0);
        return;
    }
    Block block;
    for (int64_t first = 0; first < count; first += kBlock) {
        const int size = int(std::min<int64_t>(kBlock, count - first));
        sum_up(weights + first * handles, handles, rotation_vectors, log_scales, size, block);
        if (grows) {
            for (double& growth : block.growth) growth = exponential_less_1(growth);
        }
        turn(block, normals + 3 * first, size, out + 3 * first);
    }
}

}  // namespace henkei
