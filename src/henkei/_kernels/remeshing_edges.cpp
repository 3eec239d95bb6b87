// Splits, collapses and flips of edges; see remeshing.cpp.
#include <algorithm>
#include <cmath>

#include "kernels.hpp"
#include "remeshing.hpp"

namespace henkei {
namespace {

constexpr double kLong = 4.0 / 3, kShort = 4.0 / 5;  // of the wished length
constexpr double kMuchTooLong = 2;  // of the wished length: its halves are not short
constexpr double kTiny = 0.2;       // of the wished length
constexpr double kShorter = 0.9;    // of the length before
constexpr double kGoodShape = 0.3;  // that a collapse may always leave
constexpr double kFinished = 0.01;  // of the edges: rounds end when fewer change
constexpr int kMostRounds = 40;

}  // namespace

// A sliver halved along its length is two like it side by side, again and again, unless what has
// become narrow is joined before the next halving. So edges much too long go first.
bool Remeshing::split_long(int64_t most) {
    double longest = 0;
    for (int32_t h = 0; h < mesh_.half_edge_count(); ++h) {
        if (mesh_.is_first(h)) longest = std::max(longest, relative_length(h));
    }
    for (; longest > kMuchTooLong && mesh_.face_count() <= most; longest /= 2) {
        split_longer(kMuchTooLong, most);
        collapse_short();
        flip();
    }
    for (int round = 0; round < kMostRounds && mesh_.face_count() <= most; ++round) {
        if (!split_longer(kLong, most)) break;
    }
    return mesh_.face_count() <= most;
}

// Halves each edge longer than a multiple of what is wished; whether there were any.
bool Remeshing::split_longer(double than, int64_t most) {
    Ranked edges;
    for (int32_t h = 0; h < mesh_.half_edge_count(); ++h) {
        if (!mesh_.is_first(h)) continue;
        const double length = relative_length(h);
        if (length > than) edges.push_back({-length, h});
    }
    std::sort(edges.begin(), edges.end());
    bool found = false;
    int64_t steps = 0;
    for (const auto& [key, h] : edges) {
        if (++steps % kCheckEvery == 0) check_interrupt();
        if (mesh_.face_count() > most) break;
        if (relative_length(h) <= than) continue;
        const SurfacePlace middle = middle_of(h);
        if (!shortens(h, middle.point) || !keeps_upright(h, middle.point)) continue;
        split(h, middle);
        found = true;
    }
    return found;
}

// Whether no other edge of its faces has to be split first, and the new ones are shorter than the
// longest: else there might be no end.
bool Remeshing::shortens(int32_t h, const Vec& middle) const {
    for (const int32_t side : {h, mesh_.twin(h)}) {
        if (side < 0) continue;
        double longest = edge_length(h);
        for (const int32_t e : {TriangleEdits::next(side), TriangleEdits::previous(side)}) {
            if (edge_length(e) > edge_length(h) && relative_length(e) > kLong) return false;
            longest = std::max(longest, edge_length(e));
        }
        for (int k = 0; k < 3; ++k) {
            const int32_t v = mesh_.corners(side / 3)[k];
            if (henkei::length(point(v) - middle) > kShorter * longest) return false;
        }
    }
    return true;
}

SurfacePlace Remeshing::middle_of(int32_t h) {
    const Line line = mesh_.line(h);
    if (line.exists()) return curves_.at(line.curve, line.start + line.step / 2);
    const Vec middle = 0.5 * (point(mesh_.origin(h)) + point(mesh_.target(h)));
    return surface_.nearest(fit_[h / 3].face, middle);
}

void Remeshing::split(int32_t h, const SurfacePlace& middle) {
    const Line line = mesh_.line(h);
    const int32_t t = mesh_.twin(h);
    before_.assign({h / 3});
    if (t >= 0) before_.push_back(t / 3);
    places_.clear();
    for (int32_t f : before_) lost_.gather(f, places_);
    int32_t onward;
    const int32_t m = mesh_.split(h, onward);
    add_vertex(middle, line.exists() ? FeatureKind::kLine : FeatureKind::kSmooth);
    if (line.exists()) {
        mesh_.set_line(h, {line.curve, line.start, line.step / 2});
        mesh_.set_line(onward, {line.curve, line.start + line.step / 2, line.step / 2});
    }
    add_face(onward / 3, h / 3);
    after_.assign({shape_of(h / 3), shape_of(onward / 3)});
    if (t >= 0) {
        const int32_t beside = mesh_.twin(onward) / 3;
        add_face(beside, t / 3);
        after_.push_back(shape_of(t / 3));
        after_.push_back(shape_of(beside));
    }
    replace(before_, places_, after_, kTolerance * length_[m]);
}

void Remeshing::collapse_short() {
    int64_t steps = 0;
    for (int round = 0; round < kMostRounds; ++round) {
        Ranked edges;
        for (int32_t h = 0; h < mesh_.half_edge_count(); ++h) {
            if (!mesh_.is_first(h)) continue;
            const double length = relative_length(h);
            if (length < kShort) edges.push_back({length, h});
        }
        std::sort(edges.begin(), edges.end());
        int64_t done = 0;
        for (const auto& [key, h] : edges) {
            if (++steps % kCheckEvery == 0) check_interrupt();
            if (!mesh_.has_edge(h) || relative_length(h) >= kShort) continue;
            const int32_t v = mesh_.origin(h), w = mesh_.target(h);
            done += try_collapse(h, v) || try_collapse(h, w);
        }
        if (double(done) <= kFinished * double(edges.size())) break;
    }
}

// Of a vertex on a feature line that is to vanish along an edge: how its line goes on then. Without
// an end where the edge is none of the line, or where the line would close on fewer than three
// edges.
Remeshing::JoinedLine Remeshing::joined_line(int32_t h, int32_t gone, int32_t kept) const {
    if (!mesh_.line(h).exists()) return {};
    const Line first = mesh_.origin(h) == kept ? mesh_.line(h) : mesh_.line(h).reversed();
    JoinedLine joined;
    mesh_.edges_at(gone, [&](int32_t u, int32_t e, bool leaves) {
        if (u == kept || !mesh_.line(e).exists()) return;
        const Line second = leaves ? mesh_.line(e) : mesh_.line(e).reversed();
        joined = {u, {first.curve, first.start, first.step + second.step}};
    });
    for (const int32_t side : {h, mesh_.twin(h)}) {
        if (side < 0 || mesh_.apex(side) != joined.end) continue;
        const int32_t next = TriangleEdits::next(side), previous = TriangleEdits::previous(side);
        if (mesh_.line(next).exists() && mesh_.line(previous).exists()) return {};
    }
    return joined;
}

// Whether edges would become so long that they had to be split. Those that are much too long now
// are split anyway, and tiny edges make hardly a difference.
bool Remeshing::makes_long(int32_t gone, int32_t kept) const {
    if (henkei::length(point(gone) - point(kept)) < kTiny * wished(gone, kept)) return false;
    bool found = false;
    mesh_.neighbours(gone, [&](int32_t u) {
        const double now = henkei::length(point(u) - point(gone)) / wished(gone, u);
        const double after = henkei::length(point(u) - point(kept)) / wished(kept, u);
        found |= u != kept && after > kLong && now <= kMuchTooLong;
    });
    return found;
}

bool Remeshing::try_collapse(int32_t h, int32_t gone) {
    const int32_t kept = mesh_.origin(h) == gone ? mesh_.target(h) : mesh_.origin(h);
    if (kind_[gone] == FeatureKind::kCorner || mesh_.degree(gone) > kMostDegree) return false;
    const double tolerance = kTolerance * length_[gone];
    JoinedLine joined;
    if (kind_[gone] == FeatureKind::kLine) {
        joined = joined_line(h, gone, kept);
        if (joined.end < 0 || curves_.deviation(joined.line) > tolerance) return false;
    }
    if (makes_long(gone, kept) || !mesh_.can_collapse(h)) return false;
    before_.clear();
    after_.clear();
    places_.assign({point(gone)});
    Worst worst;
    mesh_.around(gone, [&](int32_t e) {
        const int32_t f = e / 3;
        FaceShape face = shape_of(f);
        before_.push_back(f);
        lost_.gather(f, places_);
        add_to(worst, face);
        if (f == h / 3 || (mesh_.twin(h) >= 0 && f == mesh_.twin(h) / 3)) return;
        face.vertex[e % 3] = kept;
        face.x[e % 3] = point(kept);
        after_.push_back(face);
    });
    worst.shape = std::min(worst.shape, kGoodShape);
    if (!fits(after_, worst, tolerance)) return false;
    if (!after_.empty() && !are_near(places_, after_, tolerance)) return false;
    for (size_t k = 0; k < after_.size(); ++k) fit_[after_[k].face] = fits_[k];
    replace(before_, places_, after_, tolerance);
    mesh_.collapse(h, gone);
    if (joined.end < 0) return true;
    int32_t edge = -1;
    bool outward = false;
    mesh_.edges_at(kept, [&](int32_t u, int32_t e, bool leaves) {
        if (u == joined.end) edge = e, outward = leaves;
    });
    mesh_.set_line(edge, outward ? joined.line : joined.line.reversed());
    return true;
}

void Remeshing::flip() {
    for (int32_t h = 0; h < mesh_.half_edge_count(); ++h) {
        if (h % kCheckEvery == 0) check_interrupt();
        if (mesh_.is_first(h) && mesh_.twin(h) >= 0) try_flip(h);
    }
}

// By how much a flip of edge a, b to c, d lowers the sum of squared differences from regular
// degrees.
int Remeshing::regularity_gain(int32_t a, int32_t b, int32_t c, int32_t d) const {
    int gain = 0;
    for (const auto& [v, change] : {std::pair{a, -1}, {b, -1}, {c, 1}, {d, 1}}) {
        const int now = mesh_.degree(v) - (mesh_.on_boundary(v) ? 4 : 6);
        gain += now * now - (now + change) * (now + change);
    }
    return gain;
}

bool Remeshing::try_flip(int32_t h) {
    const int32_t t = mesh_.twin(h), f = h / 3, g = t / 3;
    const int32_t a = mesh_.origin(h), b = mesh_.target(h), c = mesh_.apex(h), d = mesh_.apex(t);
    if (mesh_.line(h).exists() || (separated_ && is_feature(c) && is_feature(d))) return false;
    const FaceShape one{f, {d, b, c}, {point(d), point(b), point(c)}};
    const FaceShape other{g, {c, a, d}, {point(c), point(a), point(d)}};
    const Vec &normal_f = fit_[f].normal, &normal_g = fit_[g].normal;
    const double before =
        std::min(quality(shape_of(f), normal_f).shape, quality(shape_of(g), normal_g).shape);
    const double after = std::min(quality(one, normal_f).shape, quality(other, normal_g).shape);
    const int gain = regularity_gain(a, b, c, d);
    // A more regular flip may cost a little shape, a less regular one has to be worth it.
    const bool better = gain > 0    ? after > std::min(0.9 * before, 0.7)
                        : gain == 0 ? after > before + 0.02
                                    : after > 1.25 * before;
    if (!better || !mesh_.can_flip(h)) return false;
    const double tolerance = kTolerance * 0.5 * (wished(a, b) + wished(c, d));
    before_.assign({f, g});
    after_.assign({one, other});
    Worst worst;
    for (int32_t face : before_) add_to(worst, shape_of(face));
    worst.shape = after;
    if (!fits(after_, worst, tolerance)) return false;
    places_.assign({0.5 * (point(a) + point(b))});
    for (int32_t face : before_) lost_.gather(face, places_);
    if (!are_near(places_, after_, tolerance)) return false;
    places_.erase(places_.begin());
    fit_[f] = fits_[0];
    fit_[g] = fits_[1];
    replace(before_, places_, after_, tolerance);
    mesh_.flip(h);
    return true;
}

void Remeshing::separate() {
    separated_ = true;
    for (int32_t f = 0, faces = mesh_.face_count(); f < faces; ++f) {
        bool all = mesh_.has_face(f);
        for (int k = 0; k < 3; ++k) all = all && mesh_.line(3 * f + k).exists();
        if (all) split_middle(f);
    }
    const auto is_chord = [&](int32_t h) {
        return mesh_.is_first(h) && !mesh_.line(h).exists() && is_feature(mesh_.origin(h)) &&
               is_feature(mesh_.target(h));
    };
    for (bool found = true; found;) {  // a split may move another chord to a new half-edge
        found = false;
        Ranked chords;
        for (int32_t h = 0; h < mesh_.half_edge_count(); ++h) {
            if (is_chord(h)) chords.push_back({-edge_length(h), h});
        }
        std::sort(chords.begin(), chords.end());
        for (const auto& [key, h] : chords) {
            if (!is_chord(h)) continue;
            split(h, middle_of(h));
            found = true;
        }
    }
}

}  // namespace henkei
