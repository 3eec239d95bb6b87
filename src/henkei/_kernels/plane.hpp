// The exact predicates of the plane: integer points, every sign decided without rounding.
// A point (x, y) is the triple (x, y, 1), and `left` the determinant of three triples; a surface of
// another kind (the sphere: directions) offers the same functions over its own points.
#pragma once

#include <cstdint>

namespace henkei {

using Wide = __int128;

struct PlanePoint {
    int64_t x, y;  // at most 2^61 in absolute value, so that `area` stays within 126 bits
};

inline int sign(Wide value) {
    return (value > 0) - (value < 0);
}

// Twice the signed area of the triangle p, q, r: positive if r lies left of the line from p to q.
inline Wide area(PlanePoint p, PlanePoint q, PlanePoint r) {
    return Wide(q.x - p.x) * (r.y - p.y) - Wide(r.x - p.x) * (q.y - p.y);
}

// The left-side test (eq. 6): 1 left, -1 right, 0 on the line from p to q.
inline int left(PlanePoint p, PlanePoint q, PlanePoint r) {
    return sign(area(p, q, r));
}

// For three points on one line: 1 if q lies strictly between p and r, 0 if it coincides with one of
// them, -1 otherwise.
inline int between(PlanePoint p, PlanePoint q, PlanePoint r) {
    return sign(Wide(q.x - p.x) * (r.x - q.x) + Wide(q.y - p.y) * (r.y - q.y));
}

// For three points on one line: whether q and r lie on the same side of p.
inline bool same_side(PlanePoint p, PlanePoint q, PlanePoint r) {
    return Wide(q.x - p.x) * (r.x - p.x) + Wide(q.y - p.y) * (r.y - p.y) > 0;
}

}  // namespace henkei
