// Loops over arrays with any number of columns, row by row in memory: as few passes as possible,
// each over a number of columns known when compiled.
#pragma once

#include <cstdint>
#include <type_traits>

namespace henkei {

// Calls pass(width, stride, first) with constants `width` and `stride` for the columns from `first`
// to first + width; stride is the number of columns, or 0 where that is known only when run.
template <class Pass>
void in_columns(int64_t columns, Pass pass) {
    using std::integral_constant;
    if (columns == 1) return pass(integral_constant<int, 1>(), integral_constant<int, 1>(), 0);
    if (columns == 3) return pass(integral_constant<int, 3>(), integral_constant<int, 3>(), 0);
    const integral_constant<int, 0> stride;
    int64_t first = 0;
    for (; first + 8 <= columns; first += 8) pass(integral_constant<int, 8>(), stride, first);
    for (; first + 2 <= columns; first += 2) pass(integral_constant<int, 2>(), stride, first);
    for (; first < columns; ++first) pass(integral_constant<int, 1>(), stride, first);
}

}  // namespace henkei
