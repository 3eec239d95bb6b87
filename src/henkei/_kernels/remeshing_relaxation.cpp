// Vertices moved along the surface and along features; see remeshing.cpp.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "kernels.hpp"
#include "remeshing.hpp"

namespace henkei {
namespace {

constexpr double kSteps[] = {1.0, 0.4};  // of the way, tried one after the other
constexpr double kGoodShape = 0.6;       // that a move may always leave

}  // namespace

void Remeshing::relax() {
    for (int32_t v = 0; v < mesh_.vertex_count(); ++v) {
        if (v % kCheckEvery == 0) check_interrupt();
        if (!mesh_.has_vertex(v) || mesh_.degree(v) > kMostDegree) continue;
        if (kind_[v] == FeatureKind::kSmooth) move(v);
        if (kind_[v] == FeatureKind::kLine) slide(v);
    }
    refit();
}

void Remeshing::refit() {
    for (int32_t f = 0; f < mesh_.face_count(); ++f) {
        if (f % kCheckEvery == 0) check_interrupt();
        if (mesh_.has_face(f)) fit_[f] = fit(shape_of(f), fit_[f].face);
    }
}

// The middle of the faces round a vertex, weighted by how many wished faces they stand for.
Vec Remeshing::centre(int32_t v) const {
    Vec sum{}, plain{};
    double total = 0;
    int count = 0;
    mesh_.around(v, [&](int32_t h) {
        const FaceShape face = shape_of(h / 3);
        const double side =
            length_[face.vertex[0]] + length_[face.vertex[1]] + length_[face.vertex[2]];
        const double weight = henkei::length(face.area_vector()) / (side * side);
        sum = sum + weight * face.middle();
        plain = plain + face.middle();
        total += weight;
        ++count;
    });
    return total > 0 ? (1 / total) * sum : (1.0 / count) * plain;
}

void Remeshing::move(int32_t v) {
    const SurfacePlace now = place_[v];
    const Vec normal = surface_.normal(now.face, now.weights);
    Vec shift = centre(v) - now.point;
    shift = shift - dot(shift, normal) * normal;
    for (const double step : kSteps) {
        if (move_to(v, surface_.nearest(now.face, now.point + step * shift))) return;
    }
}

// A vertex of a feature line moves to where the edges beside it are as wished, by each other.
void Remeshing::slide(int32_t v) {
    struct Side {
        int32_t edge;
        bool leaves;
        Line line;
        double wished;
    };
    std::array<Side, 2> sides;
    int count = 0;
    mesh_.edges_at(v, [&](int32_t u, int32_t e, bool leaves) {
        if (!mesh_.line(e).exists()) return;
        const Line line = leaves ? mesh_.line(e) : mesh_.line(e).reversed();
        sides[count++] = {e, leaves, line, wished(u, v)};
    });
    const Line line = sides[0].line;
    const double share = sides[0].wished / (sides[0].wished + sides[1].wished);
    const double by = line.step - share * (line.step - sides[1].line.step);
    for (const double step : kSteps) {
        std::array<Line, 2> after;
        bool near = true;
        for (int k = 0; k < 2; ++k) {
            const Line& now = sides[k].line;
            after[k] = {now.curve, line.start + step * by, now.step - step * by};
            const double most = std::max(kTolerance * length_[v], curves_.deviation(now));
            near &= curves_.deviation(after[k]) <= most;
        }
        if (!near || !move_to(v, curves_.at(line.curve, line.start + step * by))) continue;
        for (int k = 0; k < 2; ++k) {
            mesh_.set_line(sides[k].edge, sides[k].leaves ? after[k] : after[k].reversed());
        }
        return;
    }
}

bool Remeshing::move_to(int32_t v, const SurfacePlace& place) {
    const double tolerance = kTolerance * length_[v];
    before_.clear();
    after_.clear();
    places_.assign({point(v)});
    Worst worst;
    mesh_.around(v, [&](int32_t h) {
        const FaceShape face = shape_of(h / 3);
        before_.push_back(face.face);
        lost_.gather(face.face, places_);
        add_to(worst, face);
        after_.push_back(face);
        after_.back().x[h % 3] = place.point;
    });
    const SurfacePlace was = std::exchange(place_[v], place);
    int turned = 0;
    bool good = true;
    for (const FaceShape& face : after_) {
        const Quality now = quality(face, fit_[face.face].normal);
        turned += is_turned(face);
        good = good && now.shape >= std::min(worst.shape, kGoodShape) &&
               now.upright >= std::min(worst.upright, kUpright);
    }
    if (!good || turned > worst.turned || !are_near(places_, after_, tolerance)) {
        place_[v] = was;
        return false;
    }
    replace(before_, places_, after_, tolerance);
    if (graded_) length_[v] = surface_.length(place.face, place.weights);
    return true;
}

}  // namespace henkei
