// Sums of doubles without rounding, for signs that must be right.
// J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates", 1997.
#pragma once

#include <cmath>

namespace henkei {

constexpr double kEpsilon = 0x1p-53;

// A sum of doubles that do not overlap, smallest first, zeros left out (Shewchuk, section 2).
struct Expansion {
    double part[192];
    int size = 0;

    void add(double b) {  // Grow-Expansion
        int kept = 0;
        for (int i = 0; i < size; ++i) {
            const double sum = b + part[i];
            const double virtual_part = sum - b;
            const double error = (b - (sum - virtual_part)) + (part[i] - virtual_part);
            if (error != 0) part[kept++] = error;
            b = sum;
        }
        if (b != 0) part[kept++] = b;
        size = kept;
    }
    void add_product(const Expansion& e, const Expansion& f, double sign) {
        for (int i = 0; i < e.size; ++i) {
            for (int j = 0; j < f.size; ++j) {
                const double product = e.part[i] * f.part[j];
                add(sign * std::fma(e.part[i], f.part[j], -product));
                add(sign * product);
            }
        }
    }
    int sign() const { return size == 0 ? 0 : (part[size - 1] > 0 ? 1 : -1); }
};

inline Expansion difference(double a, double b) {
    Expansion e;
    e.add(a);
    e.add(-b);
    return e;
}

}  // namespace henkei
