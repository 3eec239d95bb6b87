// Vectors of four numbers.
#pragma once

#if defined(__GNUC__)
#define HENKEI_INLINE inline __attribute__((always_inline))
#define HENKEI_UNROLL _Pragma("GCC unroll 8")
#pragma GCC diagnostic ignored "-Wpsabi"
#else
#define HENKEI_INLINE __forceinline
#define HENKEI_UNROLL
#endif

namespace henkei {

constexpr int kLanes = 4;

#if defined(__GNUC__)
typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));
typedef double AlignedFour __attribute__((vector_size(32)));  // for templates: these lose the above
#else
struct Four {
    double lane[4];
    double operator[](int i) const { return lane[i]; }
    Four operator*(const Four& b) const {
        return {{lane[0] * b[0], lane[1] * b[1], lane[2] * b[2], lane[3] * b[3]}};
    }
    Four operator+(const Four& b) const {
        return {{lane[0] + b[0], lane[1] + b[1], lane[2] + b[2], lane[3] + b[3]}};
    }
    Four operator-(const Four& b) const {
        return {{lane[0] - b[0], lane[1] - b[1], lane[2] - b[2], lane[3] - b[3]}};
    }
    Four& operator+=(const Four& b) { return *this = *this + b; }
    Four& operator-=(const Four& b) { return *this = *this - b; }
};
using AlignedFour = Four;
#endif

}  // namespace henkei
