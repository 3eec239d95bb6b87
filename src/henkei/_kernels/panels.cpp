// Dense arithmetic on the panels of a sparse Cholesky factor, in vectors of four numbers.
// It is compiled once for any processor and, where the compiler can, once more for one with AVX2
// and FMA, which is chosen when the program runs. All sums are taken in a fixed order.
#include "panels.hpp"

#include <cmath>

#include "vectors.hpp"

namespace henkei {

namespace {

namespace anywhere {
#include "panel_factor.hpp"
#include "panel_solve.hpp"
constexpr PanelArithmetic kArithmetic{update, factor, solve_forward, solve_backward};
}  // namespace anywhere

#if defined(__GNUC__) && defined(__x86_64__)
#define HENKEI_HAS_AVX2
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif
namespace with_avx2 {
#include "panel_factor.hpp"
#include "panel_solve.hpp"
constexpr PanelArithmetic kArithmetic{update, factor, solve_forward, solve_backward};
}  // namespace with_avx2
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

}  // namespace

const PanelArithmetic& panel_arithmetic() {
#ifdef HENKEI_HAS_AVX2
    static const bool wide = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    if (wide) return with_avx2::kArithmetic;
#endif
    return anywhere::kArithmetic;
}

double* lay_out(const PanelRows& panel, int64_t rows, double* out) {
    for (int64_t i = 0; i < panel.columns;) {
        const int64_t size = group_size(panel.columns - i);
        for (int64_t j = 0; j < i + size; ++j) {
            for (int64_t r = 0; r < size; ++r) *out++ = i + r < j ? 0 : panel.row(i + r)[j];
        }
        i += size;
    }
    for (int64_t i = panel.columns; i < rows;) {
        const int64_t size = group_size(rows - i);
        for (int64_t j = 0; j < panel.columns; ++j) {
            for (int64_t r = 0; r < size; ++r) *out++ = panel.row(i + r)[j];
        }
        i += size;
    }
    return out;
}

}  // namespace henkei
