// Pairs of faces that intersect, decided exactly.
// A tree of boxes (median split) finds candidates; each pair is decided by the signs of orientation
// determinants alone, as in O. Devillers, P. Guigue, "Faster Triangle-Triangle Intersection Tests",
// INRIA RR-4488, 2002 (after T. Moeller, "A Fast Triangle-Triangle Intersection Test", 1997): two
// triangles in different planes meet where an edge of one meets the other, and an edge pq meets a
// triangle in a point at which the line pq has all three sides on the same hand. A sign comes from
// floating point where its error bound allows, else from expansions (J. R. Shewchuk, "Adaptive
// Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997).
// Exact where coordinates are 0 or at most 1 and at least 2^-248 in size: no product of three
// underflows then.
#include "expansion.hpp"
#include "kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace henkei {
namespace {

using Point = std::array<double, 3>;

// a b' - b a'
Expansion cross(const Expansion& a, const Expansion& b, const Expansion& a2, const Expansion& b2) {
    Expansion e;
    e.add_product(a, b2, 1);
    e.add_product(b, a2, -1);
    return e;
}

constexpr double kBound2 = (3 + 16 * kEpsilon) * kEpsilon;  // Shewchuk's ccwerrboundA
constexpr double kBound3 = (7 + 56 * kEpsilon) * kEpsilon;  // Shewchuk's o3derrboundA

int sign_of(double x) {
    return x > 0 ? 1 : (x < 0 ? -1 : 0);
}

// Sign of the area of abc as seen along an axis.
int orient2d(const Point& a, const Point& b, const Point& c, int axis) {
    const int x = (axis + 1) % 3, y = (axis + 2) % 3;
    const double left = (a[x] - c[x]) * (b[y] - c[y]), right = (a[y] - c[y]) * (b[x] - c[x]);
    const double det = left - right;
    const double size = std::abs(left) + std::abs(right);
    if (std::abs(det) > kBound2 * size || size == 0) return sign_of(det);
    return cross(difference(a[x], c[x]), difference(a[y], c[y]), difference(b[x], c[x]),
                 difference(b[y], c[y]))
        .sign();
}

// Sign of the volume of abcd: of det(a - d, b - d, c - d).
int orient3d(const Point& a, const Point& b, const Point& c, const Point& d) {
    const double ax = a[0] - d[0], ay = a[1] - d[1], az = a[2] - d[2];
    const double bx = b[0] - d[0], by = b[1] - d[1], bz = b[2] - d[2];
    const double cx = c[0] - d[0], cy = c[1] - d[1], cz = c[2] - d[2];
    const double bc = bx * cy, cb = by * cx, ca = cx * ay, ac = cy * ax, ab = ax * by, ba = ay * bx;
    const double det = az * (bc - cb) + bz * (ca - ac) + cz * (ab - ba);
    const double size = std::abs(az) * (std::abs(bc) + std::abs(cb)) +
                        std::abs(bz) * (std::abs(ca) + std::abs(ac)) +
                        std::abs(cz) * (std::abs(ab) + std::abs(ba));
    if (std::abs(det) > kBound3 * size || size == 0) return sign_of(det);
    Expansion e[3][3];
    const Point* rows[3] = {&a, &b, &c};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) e[i][k] = difference((*rows[i])[k], d[k]);
    }
    Expansion total;
    for (int i = 0; i < 3; ++i) {
        const auto& next = e[(i + 1) % 3];
        const auto& last = e[(i + 2) % 3];
        total.add_product(cross(next[0], next[1], last[0], last[1]), e[i][2], 1);
    }
    return total.sign();
}

struct Triangle {
    const Point* p[3];
    const Point& operator[](int i) const { return *p[i % 3]; }
};

// An axis along which the triangle is seen with an area, or -1 if it has none.
int flattening_axis(const Triangle& t) {
    for (int axis = 2; axis >= 0; --axis) {
        if (orient2d(t[0], t[1], t[2], axis) != 0) return axis;
    }
    return -1;
}

bool all_on_one_side(int s0, int s1, int s2) {
    return s0 != 0 && s0 == s1 && s0 == s2;
}

// Whether the segment pq and the triangle, all in one plane, meet: no side of either parts them.
bool meet_in_plane(const Point& p, const Point& q, const Triangle& t, int axis) {
    if (all_on_one_side(orient2d(p, q, t[0], axis), orient2d(p, q, t[1], axis),
                        orient2d(p, q, t[2], axis))) {
        return false;
    }
    const int inside = orient2d(t[0], t[1], t[2], axis);
    for (int i = 0; i < 3; ++i) {
        if (orient2d(t[i], t[i + 1], p, axis) == -inside &&
            orient2d(t[i], t[i + 1], q, axis) == -inside) {
            return false;
        }
    }
    return true;
}

// Whether the segment pq and the triangle meet; sides of p and q of the triangle's plane are given.
bool meet(const Point& p, const Point& q, int side_p, int side_q, const Triangle& t) {
    if (side_p * side_q > 0) return false;
    if (side_p == 0 && side_q == 0) return meet_in_plane(p, q, t, flattening_axis(t));
    const int s0 = orient3d(p, q, t[0], t[1]), s1 = orient3d(p, q, t[1], t[2]);
    if (s0 * s1 < 0) return false;
    const int s2 = orient3d(p, q, t[2], t[0]);
    return s0 * s2 >= 0 && s1 * s2 >= 0;
}

using Corners = const int32_t*;

// Turns both faces so that the vertices they share come first, in the same order if there are two;
// returns how many they share.
int share(Corners f, Corners g, int (&of_f)[3], int (&of_g)[3]) {
    int shared = 0;
    bool taken_f[3] = {}, taken_g[3] = {};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            if (f[i] != g[j]) continue;
            of_f[shared] = i;
            of_g[shared++] = j;
            taken_f[i] = taken_g[j] = true;
        }
    }
    int rest_f = shared, rest_g = shared;
    for (int i = 0; i < 3; ++i) {
        if (!taken_f[i]) of_f[rest_f++] = i;
        if (!taken_g[i]) of_g[rest_g++] = i;
    }
    return shared;
}

// Whether any of the edges (i, i + 1), from `first` on, of s meets t.
bool edges_meet(const Triangle& s, const int (&side)[3], const Triangle& t, int first, int last) {
    for (int i = first; i <= last; ++i) {
        if (meet(s[i], s[i + 1], side[i], side[(i + 1) % 3], t)) return true;
    }
    return false;
}

// Whether two faces with an area meet elsewhere than in the vertices and the edge they share.
bool intersect(const std::vector<Point>& points, Corners f, Corners g) {
    int of_f[3], of_g[3];
    const int shared = share(f, g, of_f, of_g);
    if (shared == 3) return true;
    Triangle s, t;
    for (int i = 0; i < 3; ++i) {
        s.p[i] = &points[f[of_f[i]]];
        t.p[i] = &points[g[of_g[i]]];
    }
    if (shared == 2) {
        if (orient3d(s[0], s[1], s[2], t[2]) != 0) return false;
        const int axis = flattening_axis(s);
        return orient2d(s[0], s[1], s[2], axis) == orient2d(s[0], s[1], t[2], axis);
    }
    int side_s[3] = {}, side_t[3] = {};
    for (int i = shared; i < 3; ++i) side_s[i] = orient3d(t[0], t[1], t[2], s[i]);
    if (all_on_one_side(side_s[shared ? 1 : 0], side_s[1], side_s[2])) return false;
    for (int i = shared; i < 3; ++i) side_t[i] = orient3d(s[0], s[1], s[2], t[i]);
    if (all_on_one_side(side_t[shared ? 1 : 0], side_t[1], side_t[2])) return false;
    // What two faces have in common around a shared vertex reaches an edge opposite to it.
    const int first = shared, last = shared ? 1 : 2;
    return edges_meet(s, side_s, t, first, last) || edges_meet(t, side_t, s, first, last);
}

struct Box {
    Point low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};

    void include(const Point& p) {
        for (int k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], p[k]);
            high[k] = std::max(high[k], p[k]);
        }
    }
    bool overlaps(const Box& other) const {
        for (int k = 0; k < 3; ++k) {
            if (low[k] > other.high[k] || other.low[k] > high[k]) return false;
        }
        return true;
    }
};

// Faces in a binary tree: node n holds order[begin, end); its halves are the nodes left, left + 1.
struct Tree {
    struct Node {
        Box box;
        int32_t begin, end, left = 0;
    };
    std::vector<Node> nodes;
    std::vector<int32_t> order;

    static constexpr int32_t kLeaf = 4;

    Tree(const std::vector<Box>& boxes, std::vector<int32_t> faces) : order(std::move(faces)) {
        if (order.empty()) return;
        nodes.push_back({{}, 0, int32_t(order.size())});
        for (size_t n = 0; n < nodes.size(); ++n) {
            if (n % 4096 == 0) check_interrupt();
            const int32_t begin = nodes[n].begin, end = nodes[n].end;
            Box box, centres;  // centres are doubled: low + high
            for (int32_t i = begin; i < end; ++i) {
                const Box& b = boxes[order[i]];
                box.include(b.low);
                box.include(b.high);
                centres.include({b.low[0] + b.high[0], b.low[1] + b.high[1], b.low[2] + b.high[2]});
            }
            nodes[n].box = box;
            if (end - begin <= kLeaf) continue;
            const auto width = [&](int k) { return centres.high[k] - centres.low[k]; };
            int axis = 0;
            for (int k = 1; k < 3; ++k) axis = width(k) > width(axis) ? k : axis;
            const int32_t middle = begin + (end - begin) / 2;
            std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                             [&](int32_t f, int32_t g) {
                                 const double x = boxes[f].low[axis] + boxes[f].high[axis];
                                 const double y = boxes[g].low[axis] + boxes[g].high[axis];
                                 return x != y ? x < y : f < g;
                             });
            nodes[n].left = int32_t(nodes.size());
            nodes.push_back({{}, begin, middle});
            nodes.push_back({{}, middle, end});
        }
    }
};

}  // namespace

std::vector<int32_t> self_intersections(const double* vertices, int64_t vertex_count,
                                        const int32_t* faces, int64_t face_count, int64_t limit) {
    std::vector<Point> points(vertex_count);
    for (int64_t v = 0; v < vertex_count; ++v) {
        points[v] = {vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]};
    }
    std::vector<Box> boxes(face_count);
    std::vector<int32_t> testable;
    for (int64_t f = 0; f < face_count; ++f) {
        Triangle t;
        for (int i = 0; i < 3; ++i) {
            t.p[i] = &points[faces[3 * f + i]];
            boxes[f].include(t[i]);
        }
        if (flattening_axis(t) >= 0) testable.push_back(int32_t(f));
    }
    const Tree tree(boxes, std::move(testable));

    std::vector<std::pair<int32_t, int32_t>> found;
    const auto test = [&](int32_t f, int32_t g) {
        if (f > g) std::swap(f, g);
        if (!boxes[f].overlaps(boxes[g])) return;
        if (intersect(points, faces + 3 * int64_t(f), faces + 3 * int64_t(g))) {
            found.emplace_back(f, g);
        }
    };
    std::vector<std::pair<int32_t, int32_t>> open;
    if (!tree.nodes.empty()) open.emplace_back(0, 0);
    for (int64_t step = 0; !open.empty() && int64_t(found.size()) < limit; ++step) {
        if (step % 4096 == 0) check_interrupt();
        const auto [m, n] = open.back();
        open.pop_back();
        const Tree::Node& a = tree.nodes[m];
        const Tree::Node& b = tree.nodes[n];
        if (m != n && !a.box.overlaps(b.box)) continue;
        if (!a.left && !b.left) {
            for (int32_t i = a.begin; i < a.end; ++i) {
                for (int32_t j = m == n ? i + 1 : b.begin; j < b.end; ++j) {
                    test(tree.order[i], tree.order[j]);
                }
            }
        } else if (m == n) {
            open.emplace_back(a.left, a.left);
            open.emplace_back(a.left + 1, a.left + 1);
            open.emplace_back(a.left, a.left + 1);
        } else if (a.left && (!b.left || a.end - a.begin >= b.end - b.begin)) {
            open.emplace_back(a.left, n);
            open.emplace_back(a.left + 1, n);
        } else {
            open.emplace_back(m, b.left);
            open.emplace_back(m, b.left + 1);
        }
    }
    std::sort(found.begin(), found.end());
    if (int64_t(found.size()) > limit) found.resize(limit);
    std::vector<int32_t> pairs;
    pairs.reserve(2 * found.size());
    for (const auto& [f, g] : found) pairs.insert(pairs.end(), {f, g});
    return pairs;
}

}  // namespace henkei
