// Curves of features; see feature_curves.hpp.
#include "feature_curves.hpp"

#include <algorithm>
#include <cmath>

namespace henkei {
namespace {

constexpr double kStraight = 0.70710678118654752;  // cosine of the turn that makes a corner
constexpr double kReach = 0.5, kBeside = 0.01;     // of a wished edge, from where a turn is seen
constexpr double kApart = 0.1;                     // of a wished edge, the least between two turns
constexpr int64_t kMostSamples = 32;               // of a part of a curve

int32_t next(int32_t h) {
    return h % 3 == 2 ? h - 2 : h + 1;
}

}  // namespace

FeatureCurves::FeatureCurves(const RemeshingInput& in)
    : x_(in.x, in.x + in.vertices),
      faces_(in.faces, in.faces + 3 * in.face_count),
      kind_(in.vertices, FeatureKind::kSmooth),
      first_(in.vertices + 1, 0),
      line_(3 * in.face_count) {
    const auto is_edge = [&](int64_t h) {
        return in.feature[h] && (in.twins[h] < 0 || h < in.twins[h]);
    };
    const int64_t half_edges = 3 * in.face_count;
    for (int64_t h = 0; h < half_edges; ++h) {
        if (is_edge(h)) ++first_[from(2 * h) + 1], ++first_[to(2 * h) + 1];
    }
    for (int64_t v = 0; v < in.vertices; ++v) first_[v + 1] += first_[v];
    leaving_.resize(first_[in.vertices]);
    std::vector<int64_t> fill(first_.begin(), first_.end() - 1);
    for (int64_t h = 0; h < half_edges; ++h) {
        if (!is_edge(h)) continue;
        leaving_[fill[from(2 * h)]++] = 2 * h;
        leaving_[fill[to(2 * h)]++] = 2 * h + 1;
    }
    for (int64_t v = 0; v < in.vertices; ++v) {
        const int64_t degree = first_[v + 1] - first_[v];
        if (degree > 0) kind_[v] = degree == 2 ? FeatureKind::kLine : FeatureKind::kCorner;
    }
    std::vector<int32_t> turning;
    for (int64_t v = 0; v < in.vertices; ++v) {
        if (kind_[v] == FeatureKind::kLine && turns(v, in.length[v])) turning.push_back(v);
    }
    for (int32_t v : turning) {
        if (!near_corner(v, kApart * in.length[v])) kind_[v] = FeatureKind::kCorner;
    }
    std::vector<uint8_t> traced(half_edges, 0);
    for (const FeatureKind start : {FeatureKind::kCorner, FeatureKind::kLine}) {
        for (int64_t v = 0; v < in.vertices; ++v) {
            if (kind_[v] != start) continue;
            for (int64_t k = first_[v]; k < first_[v + 1]; ++k) trace(leaving_[k], traced);
        }
    }
    for (int64_t h = 0; h < half_edges; ++h) {
        if (is_edge(h) && in.twins[h] >= 0) line_[in.twins[h]] = line_[h].reversed();
    }
}

int32_t FeatureCurves::from(Leaving e) const {
    return faces_[e % 2 ? next(e / 2) : e / 2];
}

int32_t FeatureCurves::to(Leaving e) const {
    return faces_[e % 2 ? e / 2 : next(e / 2)];
}

// The edge that goes on where e ends, or -1.
FeatureCurves::Leaving FeatureCurves::onward(Leaving e) const {
    const int32_t v = to(e);
    if (kind_[v] != FeatureKind::kLine) return -1;
    const Leaving one = leaving_[first_[v]], other = leaving_[first_[v] + 1];
    return one / 2 == e / 2 ? other : one;
}

// What is `reach` away along the features, or their end before.
FeatureCurves::Ahead FeatureCurves::ahead(int32_t vertex, Leaving e, double reach) const {
    double gone = 0;
    Vec at = x_[vertex];
    while (e >= 0) {
        const double step = length(end(e) - at);
        if (gone + step >= reach) return {at + ((reach - gone) / step) * (end(e) - at), false};
        gone += step;
        at = end(e);
        if (to(e) == vertex) break;
        e = onward(e);
    }
    return {at, true};
}

// By more than 45 degrees, both close by and from afar.
bool FeatureCurves::turns(int32_t v, double wished) const {
    const Leaving one = leaving_[first_[v]], other = leaving_[first_[v] + 1];
    for (const double reach : {kBeside * wished, kReach * wished}) {
        const Vec back = x_[v] - ahead(v, one, reach).point,
                  on = ahead(v, other, reach).point - x_[v];
        if (dot(unit(back), unit(on)) > kStraight) return false;
    }
    return true;
}

bool FeatureCurves::near_corner(int32_t v, double reach) const {
    const Leaving one = leaving_[first_[v]], other = leaving_[first_[v] + 1];
    return ahead(v, one, reach).ends || ahead(v, other, reach).ends;
}

void FeatureCurves::trace(Leaving e, std::vector<uint8_t>& traced) {
    if (traced[e / 2]) return;
    const int32_t curve = int32_t(curves_.size()), start = from(e);
    const size_t begin = nodes_.size();
    double s = 0;
    for (; e >= 0 && !traced[e / 2]; e = onward(e)) {
        traced[e / 2] = 1;
        const double step = length(end(e) - x_[from(e)]);
        const Line line{curve, s, step};
        line_[e / 2] = e % 2 ? line.reversed() : line;
        nodes_.push_back({from(e), s});
        edges_.push_back(e);
        s += step;
        if (to(e) == start) {
            e = -1;
            break;
        }
    }
    const int32_t last = to(edges_.back());
    nodes_.push_back({last, s});
    edges_.push_back(-1);
    const bool closed = last == start && kind_[start] == FeatureKind::kLine;
    curves_.push_back({begin, nodes_.size(), s, closed});
}

// s within the curve, and the last node before it.
double FeatureCurves::at_distance(const Curve& curve, double s, size_t& node) const {
    if (curve.closed && curve.length > 0) s -= curve.length * std::floor(s / curve.length);
    s = std::clamp(s, 0.0, curve.length);
    const auto begin = nodes_.begin() + curve.begin, end = nodes_.begin() + curve.end - 1;
    const auto after = std::upper_bound(begin + 1, end, s,
                                        [](double value, const Node& n) { return value < n.s; });
    node = size_t(after - nodes_.begin()) - 1;
    return s;
}

SurfacePlace FeatureCurves::at(int32_t curve, double s) const {
    size_t node;
    s = at_distance(curves_[curve], s, node);
    const double step = nodes_[node + 1].s - nodes_[node].s;
    const double t = step > 0 ? std::clamp((s - nodes_[node].s) / step, 0.0, 1.0) : 0.0;
    const Leaving e = edges_[node];
    const int32_t h = e / 2, start = e % 2 ? next(h) : h, finish = e % 2 ? h : next(h);
    SurfacePlace place;
    place.face = h / 3;
    place.weights[start % 3] = 1 - t;
    place.weights[finish % 3] = t;
    place.point = (1 - t) * x_[faces_[start]] + t * x_[faces_[finish]];
    return place;
}

double FeatureCurves::deviation(const Line& part) const {
    const Line forward = part.step < 0 ? part.reversed() : part;
    const Curve& curve = curves_[part.curve];
    const Vec a = at(part.curve, forward.start).point;
    const Vec b = at(part.curve, forward.start + forward.step).point;
    size_t node;
    const double s = at_distance(curve, forward.start, node), finish = s + forward.step;
    const int64_t most = int64_t(curve.end - curve.begin);
    int64_t inside = 0;
    {
        size_t last;
        at_distance(curve, finish, last);
        inside = int64_t(last) - int64_t(node);
        if (finish > curve.length || inside < 0) inside += most - 1;
    }
    const int64_t stride = std::max<int64_t>(1, inside / kMostSamples);
    double worst = 0;
    for (int64_t k = 1; k <= inside; k += stride) {
        int64_t at = int64_t(node - curve.begin) + k;
        if (at >= most) at -= most - 1;
        worst = std::max(worst, distance_to_segment(x_[nodes_[curve.begin + at].vertex], a, b));
    }
    return worst;
}

}  // namespace henkei
