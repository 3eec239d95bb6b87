// Sums of given displacements, which are all that a frame of a drag along or about a known axis is:
// at the speed of memory.
#include <algorithm>

#include "deformation.hpp"
#include "vectorised.hpp"

namespace henkei {
namespace {

constexpr int64_t kBlock = 2048;  // numbers of the result that stay in the nearest cache
constexpr int64_t kTerms = 4;     // that are added at once

template <class T>
inline void add(const T* term, double factor, int64_t size, double* sum) {
    for (int64_t i = 0; i < size; ++i) sum[i] += factor * double(term[i]);
}

// kTerms rows that lie `stride` apart
template <class T>
inline void add_many(const T* term, int64_t stride, const double* factors, int64_t size,
                     double* sum) {
    const T *second = term + stride, *third = second + stride, *fourth = third + stride;
    const double a = factors[0], b = factors[1], c = factors[2], d = factors[3];
    for (int64_t i = 0; i < size; ++i) {
        sum[i] += (a * double(term[i]) + b * double(second[i])) +
                  (c * double(third[i]) + d * double(fourth[i]));
    }
}

template <class T>
inline void blend(const T* basis, const double* coefficients, int64_t terms, const double* start,
                  int64_t count, double* sum, double* out) {
    for (int64_t first = 0; first < count; first += kBlock) {
        const int64_t size = std::min(kBlock, count - first);
        std::copy_n(start + first, size, sum);
        const T* term = basis + first;
        int64_t k = 0;
        for (; k + kTerms <= terms; k += kTerms) {
            add_many(term + k * count, count, coefficients + k, size, sum);
        }
        for (; k < terms; ++k) add(term + k * count, coefficients[k], size, sum);
        std::copy_n(sum, size, out + first);
    }
}

}  // namespace

HENKEI_VECTORISED
void blended(const double* basis, const double* coefficients, int64_t terms, const double* start,
             int64_t count, double* out) {
    double sum[kBlock];
    blend(basis, coefficients, terms, start, count, sum, out);
}

HENKEI_VECTORISED
void blended(const float* basis, const double* coefficients, int64_t terms, const double* start,
             int64_t count, double* out) {
    double sum[kBlock];
    blend(basis, coefficients, terms, start, count, sum, out);
}

HENKEI_VECTORISED
void shifted(const double* start, const double* weight, const double* vector, int64_t count,
             double* out) {
    const double x = vector[0], y = vector[1], z = vector[2];
    for (int64_t i = 0; i < count; ++i) {
        out[3 * i] = start[3 * i] + weight[i] * x;
        out[3 * i + 1] = start[3 * i + 1] + weight[i] * y;
        out[3 * i + 2] = start[3 * i + 2] + weight[i] * z;
    }
}

}  // namespace henkei
