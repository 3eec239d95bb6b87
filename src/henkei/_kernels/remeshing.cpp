// Isotropic remeshing: long edges are split, short ones collapsed, edges flipped towards regular
// degrees, and vertices relaxed along the surface (M. Botsch, L. Kobbelt: A remeshing approach to
// multiresolution modeling, SGP 2004, section 4).
//
// Every change is local, and refused where it would change the topology, turn a face over, or take
// the surface away from the input. The latter is asked both ways: the middle of each new face has
// to be near to the input, at a place whose normal agrees; and each face remembers the places of
// the input that it represents worst, so that the errors of many changes do not add up. Vertices
// of features move along their curve only.
//
// Here: the state and what decides about changes; the changes are in remeshing_edges.cpp and
// remeshing_relaxation.cpp.
#include "remeshing.hpp"

#include <algorithm>
#include <cmath>

#include "kernels.hpp"

namespace henkei {
namespace {

constexpr double kWorthKeeping = 0.3;  // of the tolerance: what is nearer is not lost
constexpr double kFlat = 1e-4;         // shape of faces whose normal says nothing
constexpr double kRounding = 1e-9;
constexpr Vec kMiddle = {1.0 / 3, 1.0 / 3, 1.0 / 3};

}  // namespace

Remeshing::Remeshing(const RemeshingInput& in)
    : surface_(in),
      curves_(in),
      mesh_(in.faces, in.twins, in.face_count, in.vertices),
      place_(in.vertices),
      length_(in.length, in.length + in.vertices),
      kind_(in.vertices),
      fit_(in.face_count) {
    for (int32_t v = 0; v < int32_t(in.vertices); ++v) {
        kind_[v] = curves_.kind(v);
        graded_ |= length_[v] != length_[0];
    }
    for (int32_t h = int32_t(3 * in.face_count) - 1; h >= 0; --h) {
        place_[in.faces[h]] = surface_.at_corner(h);
        if (mesh_.is_first(h) && curves_.line(h).exists()) mesh_.set_line(h, curves_.line(h));
    }
    lost_.resize(int32_t(in.face_count));
    for (int32_t f = 0; f < int32_t(in.face_count); ++f) {
        fit_[f] = {f, 0, surface_.face_normal(f)};
        if (dot(fit_[f].normal, fit_[f].normal) == 0) fit_[f].normal = surface_.normal(f, kMiddle);
    }
    for (int32_t f = 0; f < int32_t(in.face_count); ++f) {
        // Two triangles glued along all three sides have no edge that could be split.
        const auto across = [&](int k) { return mesh_.twin(3 * f + k) / 3; };
        const bool closed = mesh_.twin(3 * f) >= 0 && mesh_.twin(3 * f + 1) >= 0;
        if (closed && across(0) == across(1) && across(0) > f) split_middle(f);
    }
}

double Remeshing::edge_length(int32_t h) const {
    return henkei::length(point(mesh_.origin(h)) - point(mesh_.target(h)));
}

double Remeshing::relative_length(int32_t h) const {
    return edge_length(h) / wished(mesh_.origin(h), mesh_.target(h));
}

FaceShape Remeshing::shape_of(int32_t f) const {
    const int32_t* c = mesh_.corners(f);
    return {f, {c[0], c[1], c[2]}, {point(c[0]), point(c[1]), point(c[2])}};
}

Remeshing::Quality Remeshing::quality(const FaceShape& face, const Vec& normal) const {
    const Vec a = face.x[1] - face.x[0], b = face.x[2] - face.x[1], c = face.x[0] - face.x[2];
    const Vec n = face.area_vector();
    const double size = henkei::length(n), squares = dot(a, a) + dot(b, b) + dot(c, c);
    if (!(squares > 0 && size > 0)) return {0, 0};
    return {2 * std::sqrt(3.0) * size / squares, dot(n, normal) / size};
}

// Whether a face turns away from the input at all three of its corners. At a feature the side that
// is meant is not known.
bool Remeshing::is_turned(const FaceShape& face) const {
    const Vec n = face.area_vector();
    for (const int32_t v : face.vertex) {
        const SurfacePlace& place = place_[v];
        if (is_feature(v)) return false;
        if (dot(surface_.nearer_normal(place.face, place.weights, n), n) >= 0) return false;
    }
    return true;
}

Remeshing::Fit Remeshing::fit(const FaceShape& face, int32_t start) {
    const SurfacePlace place = surface_.nearest(start, face.middle());
    const Vec normal = surface_.nearer_normal(place.face, place.weights, unit(face.area_vector()));
    return {place.face, place.distance, normal};
}

void Remeshing::add_to(Worst& worst, const FaceShape& face) const {
    const Fit& fit = fit_[face.face];
    const Quality now = quality(face, fit.normal);
    worst.shape = std::min(worst.shape, now.shape);
    worst.upright = std::min(worst.upright, now.upright);
    worst.gap = std::max(worst.gap, fit.gap);
    worst.turned += is_turned(face);
}

// Whether new faces are upright, well-shaped and near to the input, or at least not worse than
// those before. Leaves how they fit in fits_.
bool Remeshing::fits(const std::vector<FaceShape>& after, Worst before, double tolerance) {
    int turned = 0;
    for (const FaceShape& face : after) {
        const Quality now = quality(face, fit_[face.face].normal);
        if (now.shape < before.shape || now.upright < std::min(before.upright, -0.5)) return false;
        turned += is_turned(face);
    }
    if (turned > before.turned) return false;
    fits_.clear();
    for (const FaceShape& face : after) {
        const Fit now = fit(face, fit_[face.face].face);
        if (now.gap > std::max(before.gap, tolerance)) return false;
        if (quality(face, now.normal).upright < std::min(before.upright, kUpright)) return false;
        fits_.push_back(now);
    }
    return true;
}

void Remeshing::add_vertex(const SurfacePlace& place, FeatureKind kind) {
    place_.push_back(place);
    kind_.push_back(kind);
    length_.push_back(graded_ ? surface_.length(place.face, place.weights) : length_[0]);
}

void Remeshing::add_face(int32_t f, int32_t like) {
    fit_.resize(mesh_.face_count());
    lost_.resize(mesh_.face_count());
    fit_[f] = Fit(fit_[like]);
}

void Remeshing::split_middle(int32_t f) {
    const SurfacePlace place = surface_.nearest(fit_[f].face, shape_of(f).middle());
    mesh_.split_face(f);
    add_vertex(place, FeatureKind::kSmooth);
    add_face(mesh_.face_count() - 2, f);
    add_face(mesh_.face_count() - 1, f);
}

// Gives the lost places of the faces before, and others, to those after.
void Remeshing::replace(const std::vector<int32_t>& before, const std::vector<Vec>& lost,
                        const std::vector<FaceShape>& after, double tolerance) {
    for (int32_t f : before) lost_.forget(f);
    lost_.assign(lost, after, kWorthKeeping * tolerance);
}

// Whether the faces beside an edge, split at a point, face the same way as before.
bool Remeshing::keeps_upright(int32_t h, const Vec& middle) const {
    for (const int32_t side : {h, mesh_.twin(h)}) {
        if (side < 0) continue;
        const FaceShape face = shape_of(side / 3);
        const Vec& normal = fit_[side / 3].normal;
        const Quality before = quality(face, normal);
        if (before.shape < kFlat) continue;
        for (const int32_t end : {side, TriangleEdits::next(side)}) {
            FaceShape part = face;
            part.x[end % 3] = middle;
            const double least = std::min(kUpright, before.upright - kRounding);
            if (quality(part, normal).upright < least) return false;
        }
    }
    return true;
}

Remeshing::Result Remeshing::result() const {
    Result r;
    std::vector<int32_t> number(mesh_.vertex_count(), -1);
    int32_t count = 0;
    for (int32_t v = 0; v < mesh_.vertex_count(); ++v) {
        if (!mesh_.has_vertex(v)) continue;
        number[v] = count++;
        r.weights.insert(r.weights.end(), place_[v].weights.begin(), place_[v].weights.end());
        r.on_face.push_back(place_[v].face);
        r.corner.push_back(kind_[v] == FeatureKind::kCorner);
    }
    for (int32_t f = 0; f < mesh_.face_count(); ++f) {
        if (!mesh_.has_face(f)) continue;
        for (int k = 0; k < 3; ++k) {
            r.faces.push_back(number[mesh_.corners(f)[k]]);
            r.feature.push_back(mesh_.line(3 * f + k).exists());
        }
    }
    return r;
}

}  // namespace henkei
