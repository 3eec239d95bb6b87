// The local step of as-rigid-as-possible deformation: the rotation that turns the edges of a vertex
// best (O. Sorkine, M. Alexa, "As-rigid-as-possible surface modeling", 2007, eq. 5-6), vertices of
// a rigid feature turning as one. It may follow what its neighbours' rotations were before, which
// keeps the fit sound where edges lie almost in a line (Z. Levi, C. Gotsman, "Smooth rotation
// enhanced as-rigid-as-possible mesh animation", 2015). The rotation of a covariance M comes from
// its singular values' sum, in closed form (F. L. Markley, "Attitude determination using vector
// observations: a fast optimal matrix algorithm", 1993), many at once; where that does not prove
// itself accurate, from the eigenvectors of the quaternions' 4x4 matrix (B. K. P. Horn,
// "Closed-form solution of absolute orientation using unit quaternions", 1987) by Jacobi's method.
#include <algorithm>
#include <cmath>
#include <vector>

#include "deformation.hpp"
#include "vectorised.hpp"

namespace henkei {
namespace {

constexpr int kBlock = 64;               // covariances at a time, entry by entry
constexpr double kUndetermined = 1e-12;  // relative size of a singular value that fixes nothing
constexpr double kSeparate = 1e-4;       // of (s1 + s2)(s1 + s3)(s2 + s3) in closed form
constexpr double kOrthogonal = 1e-8;     // error that one step makes vanish
constexpr int kNewtonSteps = 4;
constexpr int kSweeps = 30;

struct Block {
    double covariance[9][kBlock], rotation[9][kBlock], error[kBlock];
    int64_t vertex[kBlock];
    int size = 0;
};

void identity(double* rotation) {
    for (int k = 0; k < 9; ++k) rotation[k] = k % 4 == 0;
}

void from_quaternion(const double (&q)[4], double* rotation) {
    const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double w = q[0] / size, x = q[1] / size, y = q[2] / size, z = q[3] / size;
    const double matrix[9] = {
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
        2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    std::copy(matrix, matrix + 9, rotation);
}

// Rows of `vectors`: eigenvectors of a symmetric matrix; its diagonal: their eigenvalues.
void diagonalise(double (&matrix)[4][4], double (&vectors)[4][4]) {
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) vectors[i][j] = i == j;
    }
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        bool changed = false;
        for (int p = 0; p < 3; ++p) {
            for (int q = p + 1; q < 4; ++q) {
                const double off = matrix[p][q],
                             size = std::abs(matrix[p][p]) + std::abs(matrix[q][q]);
                if (!(size + std::abs(off) > size)) continue;
                changed = true;
                const double cotangent = (matrix[q][q] - matrix[p][p]) / (2 * off);
                const double tangent = std::copysign(1.0, cotangent) /
                                       (std::abs(cotangent) + std::hypot(cotangent, 1.0));
                const double cosine = 1 / std::sqrt(tangent * tangent + 1), sine = tangent * cosine;
                for (int k = 0; k < 4; ++k) {
                    const double a = matrix[p][k], b = matrix[q][k];
                    matrix[p][k] = cosine * a - sine * b;
                    matrix[q][k] = sine * a + cosine * b;
                }
                for (int k = 0; k < 4; ++k) {
                    const double a = matrix[k][p], b = matrix[k][q];
                    matrix[k][p] = cosine * a - sine * b;
                    matrix[k][q] = sine * a + cosine * b;
                }
                for (int k = 0; k < 4; ++k) {
                    const double a = vectors[p][k], b = vectors[q][k];
                    vectors[p][k] = cosine * a - sine * b;
                    vectors[q][k] = sine * a + cosine * b;
                }
            }
        }
        if (!changed) return;
    }
}

// The rotation by the smallest angle that takes the direction of M's rows to that of its columns.
void smallest_rotation(const double (&m)[9], double* rotation) {
    int column = 0;
    double longest = -1;
    double start[3], end[3];
    for (int j = 0; j < 3; ++j) {
        const double squared = m[j] * m[j] + m[3 + j] * m[3 + j] + m[6 + j] * m[6 + j];
        if (squared > longest) longest = squared, column = j;
    }
    for (int i = 0; i < 3; ++i) end[i] = m[3 * i + column] / std::sqrt(longest);
    for (int j = 0; j < 3; ++j) start[j] = m[j] * end[0] + m[3 + j] * end[1] + m[6 + j] * end[2];
    const double size = std::sqrt(start[0] * start[0] + start[1] * start[1] + start[2] * start[2]);
    for (double& s : start) s /= size;
    const double cosine = start[0] * end[0] + start[1] * end[1] + start[2] * end[2];
    const bool opposite = cosine < -1 + kUndetermined;
    if (opposite) {  // half a turn about any axis across
        int least = 0;
        for (int k = 1; k < 3; ++k) {
            if (std::abs(start[k]) < std::abs(start[least])) least = k;
        }
        for (int k = 0; k < 3; ++k) end[k] = k == least;
    }
    const double quaternion[4] = {opposite ? 0 : 1 + cosine, start[1] * end[2] - start[2] * end[1],
                                  start[2] * end[0] - start[0] * end[2],
                                  start[0] * end[1] - start[1] * end[0]};
    from_quaternion(quaternion, rotation);
}

// By eigenvectors, for every M; the identity for what is zero or not finite.
void surely_best_rotation(const double* covariance, double* rotation) {
    double largest = 0;
    for (int k = 0; k < 9; ++k) largest = std::max(largest, std::abs(covariance[k]));
    identity(rotation);
    if (!(largest > 0 && std::isfinite(largest))) return;
    double m[9];
    for (int k = 0; k < 9; ++k) m[k] = covariance[k] / largest;
    double matrix[4][4] = {
        {m[0] + m[4] + m[8], m[7] - m[5], m[2] - m[6], m[3] - m[1]},
        {m[7] - m[5], m[0] - m[4] - m[8], m[1] + m[3], m[2] + m[6]},
        {m[2] - m[6], m[1] + m[3], m[4] - m[0] - m[8], m[5] + m[7]},
        {m[3] - m[1], m[2] + m[6], m[5] + m[7], m[8] - m[0] - m[4]},
    };
    double vectors[4][4];
    diagonalise(matrix, vectors);
    int order[4] = {0, 1, 2, 3};
    std::stable_sort(order, order + 4, [&](int a, int b) { return matrix[a][a] > matrix[b][b]; });
    double value[4];
    for (int k = 0; k < 4; ++k) value[k] = matrix[order[k]][order[k]];
    const double first = value[0] + value[1] - value[2] - value[3];
    const double second = value[0] - value[1] + value[2] - value[3];
    if (second <= kUndetermined * first) {
        smallest_rotation(m, rotation);
    } else {
        from_quaternion(vectors[order[0]], rotation);
    }
}

// Markley's closed form for a block. With singular values s1 >= s2 >= |s3|, s3 < 0 for mirrored
// data, t = s1 + s2 + s3 is the largest root of (t^2 - |M|^2)^2 / 4 = |cof M|^2 + 2 t det M.
HENKEI_VECTORISED
void rotate(Block& block) {
    for (int i = 0; i < block.size; ++i) {
        double m[9], cofactor[9], n[9];
        double largest = 0;
        for (int k = 0; k < 9; ++k) m[k] = block.covariance[k][i];
        for (int k = 0; k < 9; ++k) {
            const double size = m[k] < 0 ? -m[k] : m[k];
            largest = size > largest ? size : largest;
        }
        const double factor = 1 / largest;
        for (int k = 0; k < 9; ++k) m[k] *= factor;
        cofactor[0] = m[4] * m[8] - m[5] * m[7];
        cofactor[1] = m[5] * m[6] - m[3] * m[8];
        cofactor[2] = m[3] * m[7] - m[4] * m[6];
        cofactor[3] = m[2] * m[7] - m[1] * m[8];
        cofactor[4] = m[0] * m[8] - m[2] * m[6];
        cofactor[5] = m[1] * m[6] - m[0] * m[7];
        cofactor[6] = m[1] * m[5] - m[2] * m[4];
        cofactor[7] = m[2] * m[3] - m[0] * m[5];
        cofactor[8] = m[0] * m[4] - m[1] * m[3];
        const double determinant = m[0] * cofactor[0] + m[1] * cofactor[1] + m[2] * cofactor[2];
        double squares = 0, cofactors = 0;
        for (int k = 0; k < 9; ++k) {
            squares += m[k] * m[k];
            cofactors += cofactor[k] * cofactor[k];
        }
        double sum = std::sqrt(squares + 2 * std::sqrt(cofactors));
        for (int step = 0; step < kNewtonSteps; ++step) {
            const double products = std::sqrt(cofactors + 2 * sum * determinant);
            sum -= (sum * sum - squares - 2 * products) * products /
                   (2 * (sum * products - determinant));
        }
        const double products = (sum * sum - squares) / 2;
        const double separation = sum * products - determinant;
        const double inverse = 1 / separation;
        // M' M, of which the upper triangle is kept
        const double g00 = m[0] * m[0] + m[3] * m[3] + m[6] * m[6];
        const double g01 = m[0] * m[1] + m[3] * m[4] + m[6] * m[7];
        const double g02 = m[0] * m[2] + m[3] * m[5] + m[6] * m[8];
        const double g11 = m[1] * m[1] + m[4] * m[4] + m[7] * m[7];
        const double g12 = m[1] * m[2] + m[4] * m[5] + m[7] * m[8];
        const double g22 = m[2] * m[2] + m[5] * m[5] + m[8] * m[8];
        const double d = products + squares;
        for (int k = 0; k < 9; k += 3) {
            const double a = m[k], b = m[k + 1], c = m[k + 2];
            n[k] = inverse * ((d - g00) * a - g01 * b - g02 * c + sum * cofactor[k]);
            n[k + 1] = inverse * ((d - g11) * b - g01 * a - g12 * c + sum * cofactor[k + 1]);
            n[k + 2] = inverse * ((d - g22) * c - g02 * a - g12 * b + sum * cofactor[k + 2]);
        }
        // one step of Newton and Schulz makes it orthogonal
        const double e00 = 1 - (n[0] * n[0] + n[3] * n[3] + n[6] * n[6]);
        const double e11 = 1 - (n[1] * n[1] + n[4] * n[4] + n[7] * n[7]);
        const double e22 = 1 - (n[2] * n[2] + n[5] * n[5] + n[8] * n[8]);
        const double e01 = -(n[0] * n[1] + n[3] * n[4] + n[6] * n[7]);
        const double e02 = -(n[0] * n[2] + n[3] * n[5] + n[6] * n[8]);
        const double e12 = -(n[1] * n[2] + n[4] * n[5] + n[7] * n[8]);
        for (int k = 0; k < 9; k += 3) {
            const double a = n[k], b = n[k + 1], c = n[k + 2];
            block.rotation[k][i] = a + (a * e00 + b * e01 + c * e02) / 2;
            block.rotation[k + 1][i] = b + (a * e01 + b * e11 + c * e12) / 2;
            block.rotation[k + 2][i] = c + (a * e02 + b * e12 + c * e22) / 2;
        }
        const double error =
            e00 * e00 + e11 * e11 + e22 * e22 + 2 * (e01 * e01 + e02 * e02 + e12 * e12);
        const bool separate = separation > kSeparate * squares * sum;
        block.error[i] = separate ? error : 1;
    }
}

void flush(Block& block, double* rotations) {
    rotate(block);
    for (int i = 0; i < block.size; ++i) {
        double* rotation = rotations + 9 * block.vertex[i];
        if (block.error[i] <= kOrthogonal * kOrthogonal) {
            for (int k = 0; k < 9; ++k) rotation[k] = block.rotation[k][i];
        } else {
            double covariance[9];
            for (int k = 0; k < 9; ++k) covariance[k] = block.covariance[k][i];
            surely_best_rotation(covariance, rotation);
        }
    }
    block.size = 0;
}

// The sum of w (p_i - p_j) (x_i - x_j)' over the edges of a vertex.
void covariance_of(const SparseRows& weights, const double* rest, const double* displacement,
                   const double* before, double follow, int64_t i, double (&m)[9]) {
    const double *x = rest + 3 * i, *u = displacement + 3 * i;
    double sum[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
    double around[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0}, size = 0, all = 0;
    for (int32_t k = weights.start[i]; k < weights.start[i + 1]; ++k) {
        const double weight = std::max(weights.values[k], 0.0);
        const int64_t j = 3 * int64_t(weights.indices[k]);
        const double edge[3] = {x[0] - rest[j], x[1] - rest[j + 1], x[2] - rest[j + 2]};
        const double after[3] = {edge[0] + (u[0] - displacement[j]),
                                 edge[1] + (u[1] - displacement[j + 1]),
                                 edge[2] + (u[2] - displacement[j + 2])};
        for (int r = 0; r < 3; ++r) {
            const double weighted = weight * after[r];
            for (int c = 0; c < 3; ++c) sum[3 * r + c] += weighted * edge[c];
        }
        if (!before) continue;
        size += weight * (edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2]);
        all += weight;
        for (int c = 0; c < 9; ++c) around[c] += weight * before[3 * j + c];
    }
    if (all > 0) {
        for (int c = 0; c < 9; ++c) sum[c] += follow * size / all * around[c];
    }
    std::copy(sum, sum + 9, m);
}

}  // namespace

void fitted_rotations(const SparseRows& weights, const double* rest, const double* displacement,
                      const int32_t* group, const double* before, double follow,
                      double* rotations) {
    const int64_t count = weights.count;
    const int32_t groups = count ? *std::max_element(group, group + count) + 1 : 0;
    std::vector<double> pooled(9 * std::max<int64_t>(groups, 0), 0.0);
    Block block;
    double m[9];
    for (int64_t i = 0; i < count; ++i) {
        if (group[i] == kGiven) continue;
        covariance_of(weights, rest, displacement, before, follow, i, m);
        if (group[i] >= 0) {
            for (int k = 0; k < 9; ++k) pooled[9 * int64_t(group[i]) + k] += m[k];
            continue;
        }
        for (int k = 0; k < 9; ++k) block.covariance[k][block.size] = m[k];
        block.vertex[block.size++] = i;
        if (block.size == kBlock) flush(block, rotations);
    }
    flush(block, rotations);
    if (groups <= 0) return;
    for (int32_t g = 0; g < groups; ++g) {
        surely_best_rotation(pooled.data() + 9 * int64_t(g), m);
        std::copy(m, m + 9, pooled.data() + 9 * int64_t(g));
    }
    for (int64_t i = 0; i < count; ++i) {
        if (group[i] < 0) continue;
        std::copy_n(pooled.data() + 9 * int64_t(group[i]), 9, rotations + 9 * i);
    }
}

}  // namespace henkei
