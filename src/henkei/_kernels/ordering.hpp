// Orders of elimination that keep a Cholesky factor sparse.
#pragma once

#include <cstdint>
#include <vector>

#include "elimination.hpp"

namespace henkei {

// The unknowns in the order in which to eliminate them. The pattern's diagonal does not matter.
std::vector<int32_t> minimum_degree(const Pattern& pattern);
std::vector<int32_t> nested_dissection(const Pattern& pattern);

// Only of those that are not eliminated later.
std::vector<int32_t> minimum_degree_before(const Pattern& pattern, const uint8_t* later);

}  // namespace henkei
