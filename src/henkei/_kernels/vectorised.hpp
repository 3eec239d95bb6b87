// Marks a function whose loops are worth compiling for wider vectors, too; which version runs is
// decided when the module is loaded. The versions give the same bits: no operation is reordered and
// none contracted. Elsewhere the mark means nothing.
#pragma once

#include <cstdint>

#if defined(__x86_64__) && defined(__GLIBC__) && \
    (defined(__clang__) ? __clang_major__ >= 14 : defined(__GNUC__))
#define HENKEI_VECTORISED __attribute__((target_clones("avx2", "default")))
#else
#define HENKEI_VECTORISED
#endif
