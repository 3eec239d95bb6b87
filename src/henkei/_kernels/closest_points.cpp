// Nearest points on a triangle mesh, by a tree of boxes (median split, nearer half first).
// On a triangle the nearest point is the point's projection if that falls inside, else it is on a
// side that faces the point (C. Ericson, "Real-Time Collision Detection", 2005, section 5.1). Of
// thin triangles all sides are asked in any case, and every candidate is measured as the point it
// names: a triangle without area is its sides, and rounding cannot feign a small distance.
// A side is measured from the same end in both of its faces, and boxes have room for rounding, so
// the answer, the smallest distance and among equal ones the lowest face, hangs on no order.
#include "closest_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "kernels.hpp"

namespace henkei {
namespace {

using Point = std::array<double, 3>;

constexpr int32_t kLeaf = 4;

Point minus(const Point& a, const Point& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

// a + s u
Point along(const Point& a, double s, const Point& u) {
    return {a[0] + s * u[0], a[1] + s * u[1], a[2] + s * u[2]};
}

double dot(const Point& a, const Point& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Point cross(const Point& a, const Point& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double squared_length(const Point& a) {
    return dot(a, a);
}

// Too thin for its normal to be trusted: lower than a ten-thousandth of its length.
bool is_thin(const Point& a, const Point& b, const Point& c) {
    const Point ab = minus(b, a), ac = minus(c, a);
    const double longest =
        std::max({squared_length(ab), squared_length(ac), squared_length(minus(c, b))});
    return !(squared_length(cross(ab, ac)) > 1e-8 * longest * longest);
}

}  // namespace

struct ClosestPoints::Nearest {
    double squared_distance = std::numeric_limits<double>::infinity();
    const Triangle* triangle = nullptr;
    Point weights{};

    void offer(double candidate, const Triangle& t, double u, double v, double w) {
        if (candidate > squared_distance) return;
        if (candidate == squared_distance && (!triangle || triangle->face <= t.face)) return;
        squared_distance = candidate;
        triangle = &t;
        weights = {u, v, w};
    }
};

double ClosestPoints::Node::squared_distance(const Point& p) const {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double outside = std::max(std::max(low[k] - p[k], p[k] - high[k]), 0.0);
        sum += outside * outside;
    }
    return sum;
}

ClosestPoints::ClosestPoints(const double* vertices, const int32_t* faces, int64_t face_count) {
    const auto corner = [&](int64_t f, int i) {
        const double* v = vertices + 3 * int64_t(faces[3 * f + i]);
        return Point{v[0], v[1], v[2]};
    };
    double largest = 0;
    std::vector<std::array<float, 3>> centres(face_count);
    for (int64_t f = 0; f < face_count; ++f) {
        const Point a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
        for (int k = 0; k < 3; ++k) {
            const double low = std::min({a[k], b[k], c[k]}), high = std::max({a[k], b[k], c[k]});
            centres[f][k] = float(low + high);
            largest = std::max({largest, -low, high});
        }
    }
    std::vector<int32_t> order(face_count);
    std::iota(order.begin(), order.end(), 0);
    split(centres, order);
    triangles_.resize(face_count);
    for (int64_t i = 0; i < face_count; ++i) {
        Triangle& t = triangles_[i];
        t.face = order[i];
        for (int k = 0; k < 3; ++k) t.corner[k] = corner(t.face, k);
        for (int k = 0; k < 3; ++k) t.backwards[k] = t.corner[(k + 1) % 3] < t.corner[k];
        t.thin = is_thin(t.corner[0], t.corner[1], t.corner[2]);
    }
    enclose(8 * std::numeric_limits<double>::epsilon() * largest);
}

void ClosestPoints::split(const std::vector<std::array<float, 3>>& centres,
                          std::vector<int32_t>& order) {
    if (order.empty()) return;
    nodes_.reserve(order.size());
    nodes_.push_back({{}, {}, 0, int32_t(order.size()), 0});
    for (size_t n = 0; n < nodes_.size(); ++n) {
        if (n % 4096 == 0) check_interrupt();
        const int32_t begin = nodes_[n].begin, end = nodes_[n].end;
        if (end - begin <= kLeaf) continue;
        std::array<float, 3> low = centres[order[begin]], high = low;
        for (int32_t i = begin; i < end; ++i) {
            for (int k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], centres[order[i]][k]);
                high[k] = std::max(high[k], centres[order[i]][k]);
            }
        }
        int axis = 0;
        for (int k = 1; k < 3; ++k) axis = high[k] - low[k] > high[axis] - low[axis] ? k : axis;
        const int32_t middle = begin + (end - begin) / 2;
        std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                         [&](int32_t f, int32_t g) { return centres[f][axis] < centres[g][axis]; });
        nodes_[n].left = int32_t(nodes_.size());
        nodes_.push_back({{}, {}, begin, middle, 0});
        nodes_.push_back({{}, {}, middle, end, 0});
    }
}

// The boxes, from the leaves up, `margin` larger than what they hold.
void ClosestPoints::enclose(double margin) {
    for (size_t n = nodes_.size(); n-- > 0;) {
        Node& node = nodes_[n];
        for (int k = 0; k < 3; ++k) {
            double low = std::numeric_limits<double>::infinity(), high = -low;
            if (node.left) {
                const Node &first = nodes_[node.left], &second = nodes_[node.left + 1];
                low = std::min(first.low[k], second.low[k]);
                high = std::max(first.high[k], second.high[k]);
            } else {
                for (int32_t i = node.begin; i < node.end; ++i) {
                    for (const Point& p : triangles_[i].corner) {
                        low = std::min(low, p[k] - margin);
                        high = std::max(high, p[k] + margin);
                    }
                }
            }
            node.low[k] = low;
            node.high[k] = high;
        }
    }
}

void ClosestPoints::compare(const Point& p, const Triangle& t, Nearest& nearest) {
    const Point &a = t.corner[0], &b = t.corner[1], &c = t.corner[2];
    const Point ab = minus(b, a), ac = minus(c, a), ap = minus(p, a);
    const Point normal = cross(ab, ac);
    const double area = squared_length(normal);
    double v = dot(cross(ap, ac), normal) / area, w = dot(cross(ab, ap), normal) / area;
    if (t.thin) {  // once more with what rounding left over
        const Point rest = along(along(ap, -v, ab), -w, ac);
        v += dot(cross(rest, ac), normal) / area;
        w += dot(cross(ab, rest), normal) / area;
    }
    const double weight[3] = {1 - v - w, v, w};
    const bool inside = weight[0] >= 0 && v >= 0 && w >= 0;  // false for NaN: no area
    if (inside) {
        const double d = squared_length(minus(p, along(along(a, v, ab), w, ac)));
        nearest.offer(d, t, weight[0], v, w);
        if (!t.thin) return;
    }
    for (int k = 0; k < 3; ++k) {
        if (!t.thin && weight[(k + 2) % 3] >= 0) continue;  // the triangle lies between
        const int start = t.backwards[k] ? (k + 1) % 3 : k, end = t.backwards[k] ? k : (k + 1) % 3;
        const Point side = minus(t.corner[end], t.corner[start]);
        const double length = squared_length(side);
        double s = length > 0 ? dot(minus(p, t.corner[start]), side) / length : 0;
        s = std::clamp(s, 0.0, 1.0);
        const Point q = s == 1 ? t.corner[end] : along(t.corner[start], s, side);
        const double d = squared_length(minus(p, q));
        double weights[3] = {};
        weights[start] = 1 - s;
        weights[end] = s;
        nearest.offer(d, t, weights[0], weights[1], weights[2]);
    }
}

void ClosestPoints::descend(const Point& p, Nearest& nearest) const {
    std::pair<double, int32_t> open[64];  // halves of halves: never more than one a level
    int waiting = 0;
    open[waiting++] = {0, 0};
    while (waiting) {
        const auto [distance, at] = open[--waiting];
        if (distance > nearest.squared_distance) continue;
        const Node& node = nodes_[at];
        if (!node.left) {
            for (int32_t i = node.begin; i < node.end; ++i) compare(p, triangles_[i], nearest);
            continue;
        }
        const std::pair<double, int32_t> first{nodes_[node.left].squared_distance(p), node.left},
            second{nodes_[node.left + 1].squared_distance(p), node.left + 1};
        open[waiting++] = std::max(first, second);
        open[waiting++] = std::min(first, second);
    }
}

void ClosestPoints::query(const double* points, int64_t count, int32_t* face, double* barycentric,
                          double* squared_distance) const {
    const Triangle* previous = nullptr;  // neighbours in the list are often neighbours in space
    for (int64_t i = 0; i < count; ++i) {
        if (i % 1024 == 0) check_interrupt();
        const Point p{points[3 * i], points[3 * i + 1], points[3 * i + 2]};
        Nearest nearest;
        if (previous) compare(p, *previous, nearest);
        if (!nodes_.empty()) descend(p, nearest);
        previous = nearest.triangle;
        face[i] = previous ? previous->face : -1;
        squared_distance[i] = nearest.squared_distance;
        std::copy(nearest.weights.begin(), nearest.weights.end(), barycentric + 3 * i);
    }
}

}  // namespace henkei
