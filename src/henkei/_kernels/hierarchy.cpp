#include "hierarchy.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kernels.hpp"

namespace henkei {
namespace {

constexpr int kMostNeighbours = 9;   // of a vertex that goes; one of up to 5 always may
constexpr int kCrowded = 8;          // neighbours that a vertex may come to have at no cost
constexpr double kShare = 0.3;       // of the vertices, that a level takes away at most
constexpr double kFlat = 0.02;       // added to the quality of a triangle, 0 if it has no area
constexpr double kLeastArea = 1e-4;  // of the mean, added to the area of each face
constexpr double kVanishing = 1e-200;

// 1 for an equilateral triangle, 0 for one without area.
double quality(const Vec& a, const Vec& b, const Vec& c) {
    const Vec ab = b - a, ac = c - a, bc = c - b;
    const double squares = dot(ab, ab) + dot(ac, ac) + dot(bc, bc);
    if (!(squares > kVanishing)) return 0;
    return 2 * std::sqrt(3.0) * length(cross(ab, ac)) / squares;
}

}  // namespace

Hierarchy::Hierarchy(const double* vertices, int64_t vertex_count, const int32_t* faces,
                     const int32_t* twins, int64_t face_count)
    : point_(vertex_count),
      corner_(faces, faces + 3 * face_count),
      twin_(twins, twins + 3 * face_count),
      leaving_(vertex_count, -1),
      degree_(vertex_count, 0),
      present_(vertex_count),
      area_(face_count) {
    for (int64_t v = 0; vertices != nullptr && v < vertex_count; ++v) {
        point_[v] = {vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]};
    }
    for (int64_t h = 0; h < 3 * face_count; ++h) {
        leaving_[corner_[h]] = int32_t(h);
        ++degree_[corner_[h]];
    }
    for (int64_t f = 0; f < face_count; ++f) {
        const Vec &a = point_[faces[3 * f]], &b = point_[faces[3 * f + 1]];
        area_[f] = length(cross(b - a, point_[faces[3 * f + 2]] - a)) / 2;
    }
    double total = std::accumulate(area_.begin(), area_.end(), 0.0);
    const double least = total > kVanishing ? kLeastArea * total / double(face_count) : 1.0;
    total += least * double(face_count);
    for (double& area : area_) area = (area + least) * (4 * M_PI / total);
    std::iota(present_.begin(), present_.end(), 0);
    while (present_.size() > 4 && collapse_level()) check_interrupt();
}

void Hierarchy::find_ring(int32_t v) {
    ring_.clear();
    const int32_t first = leaving_[v];
    int32_t h = first;
    do {
        ring_.push_back(h);
        h = turned(h);
    } while (h != first);
}

bool Hierarchy::joined(int32_t a, int32_t b) const {
    if (degree_[a] > degree_[b]) std::swap(a, b);
    const int32_t first = leaving_[a];
    int32_t h = first;
    do {
        if (target(h) == b) return true;
        h = turned(h);
    } while (h != first);
    return false;
}

// The link condition: the two ends have no other common neighbours than the two beside the edge.
bool Hierarchy::keeps_sphere(int32_t at, int32_t degree) const {
    const int32_t u = target(ring_[at]);
    for (int32_t k = 2; k + 1 < degree; ++k) {
        if (joined(u, target(ring_[(at + k) % degree]))) return false;
    }
    return true;
}

Hierarchy::Choice Hierarchy::best_collapse(int32_t v) {
    find_ring(v);
    const int32_t degree = int32_t(ring_.size());
    double star = 0;
    for (const int32_t h : ring_) star += area_[h / 3];
    std::vector<std::pair<double, int32_t>> costs;
    for (int32_t at = 0; at < degree; ++at) {
        const int32_t u = target(ring_[at]);
        double worst = 1;
        for (int32_t k = 1; k + 1 < degree; ++k) {
            const int32_t a = target(ring_[(at + k) % degree]);
            const int32_t b = target(ring_[(at + k + 1) % degree]);
            worst = std::min(worst, quality(point_[u], point_[a], point_[b]));
        }
        double cost = star / (worst + kFlat);
        const int32_t crowd = degree_[u] + degree - 4 - kCrowded;
        if (crowd > 0) cost *= 1 + crowd;
        costs.emplace_back(cost, at);
    }
    std::sort(costs.begin(), costs.end());
    for (const auto& [cost, at] : costs) {
        if (keeps_sphere(at, degree)) return {cost, ring_[at]};
    }
    return {INFINITY, -1};
}

bool Hierarchy::collapse_level() {
    std::vector<Choice> choices;
    choices.reserve(present_.size());
    for (const int32_t v : present_) {
        if (degree_[v] > kMostNeighbours) continue;
        const Choice choice = best_collapse(v);
        if (choice.half_edge >= 0) choices.push_back(choice);
    }
    std::sort(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) {
        return a.cost != b.cost ? a.cost < b.cost : a.half_edge < b.half_edge;
    });
    const int64_t most = std::max(int64_t(1), int64_t(kShare * double(present_.size())));
    std::vector<char> kept(leaving_.size(), 0), gone(leaving_.size(), 0);
    int64_t count = 0;
    for (const Choice& choice : choices) {
        if (count == most || int64_t(present_.size()) - count <= 4) break;
        const int32_t v = corner_[choice.half_edge];
        if (kept[v]) continue;
        find_ring(v);
        // The ring is as it was, but its vertices may have been joined since.
        const auto at = std::find(ring_.begin(), ring_.end(), choice.half_edge) - ring_.begin();
        if (!keeps_sphere(int32_t(at), int32_t(ring_.size()))) continue;
        for (const int32_t h : ring_) kept[target(h)] = 1;
        collapse(choice.half_edge);
        gone[v] = 1;
        ++count;
    }
    if (count == 0) return false;
    levels_.push_back(count);
    present_.erase(
        std::remove_if(present_.begin(), present_.end(), [&](int32_t v) { return gone[v] != 0; }),
        present_.end());
    return true;
}

void Hierarchy::collapse(int32_t h) {
    const int32_t v = corner_[h], u = target(h), t = twin_[h];
    find_ring(v);
    const int32_t degree = int32_t(ring_.size());
    const auto start = std::find(ring_.begin(), ring_.end(), h);
    std::rotate(ring_.begin(), start, ring_.end());
    // The area of the faces that vanish goes to those that stay.
    const double share = (area_[h / 3] + area_[t / 3]) / (degree - 2);
    for (int32_t k = 1; k + 1 < degree; ++k) {
        const int32_t face = ring_[k] / 3;
        areas_.push_back(area_[face]);
        area_[face] += share;
    }
    for (int32_t k = 1; k + 1 < degree; ++k) corner_[ring_[k]] = u;
    const int32_t a = twin_[next(h)], b = twin_[previous(h)];
    const int32_t c = twin_[next(t)], e = twin_[previous(t)];
    twin_[a] = b, twin_[b] = a, twin_[c] = e, twin_[e] = c;
    leaving_[u] = b, leaving_[corner_[a]] = a, leaving_[corner_[c]] = c;
    degree_[u] += degree - 4;
    --degree_[corner_[a]], --degree_[corner_[c]];
    collapses_.push_back(h);
}

void Hierarchy::coming_ring(std::vector<int32_t>& ring) const {
    const int32_t h = collapses_.back(), t = twin_[h];
    ring.assign(1, target(h));
    const int32_t last = twin_[previous(t)];
    int32_t g = twin_[previous(h)];
    ring.push_back(target(g));
    while (g != last) {
        g = turned(g);
        ring.push_back(target(g));
    }
}

void Hierarchy::split() {
    const int32_t h = collapses_.back();
    collapses_.pop_back();
    if (--levels_.back() == 0) levels_.pop_back();
    // The two faces that had vanished keep their corners and twins.
    const int32_t v = corner_[h], u = target(h), t = twin_[h];
    const int32_t a = twin_[next(h)], b = twin_[previous(h)];
    const int32_t c = twin_[next(t)], e = twin_[previous(t)];
    twin_[a] = next(h), twin_[b] = previous(h), twin_[c] = next(t), twin_[e] = previous(t);
    leaving_[v] = h, leaving_[u] = t;
    ring_.clear();
    for (int32_t g = b; g != next(t); g = turned(g)) {
        corner_[g] = v;
        ring_.push_back(g);
    }
    for (auto g = ring_.rbegin(); g != ring_.rend(); ++g) {
        area_[*g / 3] = areas_.back();
        areas_.pop_back();
    }
    const int32_t degree = int32_t(ring_.size()) + 2;
    degree_[u] -= degree - 4;
    ++degree_[corner_[a]], ++degree_[corner_[previous(t)]];
    degree_[v] = degree;
    present_.push_back(v);
}

}  // namespace henkei
