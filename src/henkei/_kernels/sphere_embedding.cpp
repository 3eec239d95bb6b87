// An injective map of any closed surface of genus 0 onto the unit sphere.
// E. Praun, H. Hoppe, "Spherical Parametrization and Remeshing", SIGGRAPH 2003: the mesh is taken
// apart down to a tetrahedron, which is laid on the sphere; then the vertices come back, each into
// the kernel of the polygon of its neighbours, so that no face is ever turned over; between levels
// vertices are moved to where the map distorts less. As in H. Shen, Z. Jiang, D. Zorin, D. Panozzo,
// "Progressive Embedding", SIGGRAPH 2019, validity rests on connectivity alone.
#include <algorithm>
#include <cmath>

#include "hierarchy.hpp"
#include "kernels.hpp"
#include "sphere_ring.hpp"

namespace henkei {
namespace {

constexpr double kSliver = 1e-2;       // added to the squares of a face's sides, of their mean
constexpr double kVanishing = 1e-200;  // squared length that counts as none
constexpr double kOver = 1.8;          // part of Newton's step that sweeps take
constexpr double kSettled = 1e-4;      // fall of a vertex's energy that is not worth moving for
constexpr int kPlacing = 4;            // times that a vertex is moved when it comes back
constexpr int kMostSweeps = 100;       // of one level
constexpr int kSnaps = 50;             // rounds of moves to desired places

// What a face asks of its image: weights of the squared lengths of its sides, and its area.
struct Shape {
    double cotangent[3];
    double area;
};

class Embedding {
  public:
    Embedding(Hierarchy& mesh, int64_t vertices, int64_t faces, const double* desired,
              double area_weight);

    void lay_tetrahedron();
    bool grow(int sweeps);
    void snap();
    const std::vector<Vec>& positions() const { return x_; }

  private:
    void measure(int32_t face);
    void gather(int32_t v);
    bool relax(int32_t v, double part);
    void sweep();
    bool place(int32_t v);
    bool kernel_centre(Vec& centre);
    void clip(size_t s);
    template <class Visit>
    void for_ring(int32_t v, Visit visit) const;

    Hierarchy& mesh_;
    std::vector<Vec> x_, desired_;
    std::vector<Shape> shape_;
    std::vector<char> awake_;
    SphereRing ring_;
    std::vector<int32_t> coming_;
    std::vector<Vec> corner_, side_, part_, rest_;  // of kernel_centre and clip
};

Embedding::Embedding(Hierarchy& mesh, int64_t vertices, int64_t faces, const double* desired,
                     double area_weight)
    : mesh_(mesh), x_(vertices), shape_(faces), awake_(vertices, 0) {
    ring_.area_weight = area_weight;
    if (desired == nullptr) return;
    desired_.resize(vertices);
    for (int64_t v = 0; v < vertices; ++v) {
        desired_[v] = unit({desired[3 * v], desired[3 * v + 1], desired[3 * v + 2]});
    }
}

// Visits the half-edges that leave v, counter-clockwise.
template <class Visit>
void Embedding::for_ring(int32_t v, Visit visit) const {
    const int32_t first = mesh_.leaving(v);
    int32_t h = first;
    do {
        visit(h);
        h = mesh_.turned(h);
    } while (h != first);
}

void Embedding::lay_tetrahedron() {
    const int32_t a = mesh_.present()[0], h = mesh_.leaving(a);
    const int32_t b = mesh_.target(h), c = mesh_.target(mesh_.turned(h));
    const int32_t d = mesh_.target(mesh_.turned(mesh_.turned(h)));
    Vec up{0, 0, 1}, out{1, 0, 0};
    if (!desired_.empty()) {
        up = desired_[a];
        out = desired_[b] - dot(desired_[b], up) * up;
        out = length(out) > 1e-6 ? unit(out) : Tangents(up).e;
    }
    const Vec side = cross(up, out);
    const auto below = [&](double turns) {
        const double angle = 2 * M_PI * turns, r = std::sqrt(8.0) / 3;
        return unit((-1.0 / 3) * up + r * (std::cos(angle) * out + std::sin(angle) * side));
    };
    x_[a] = up, x_[b] = below(0), x_[c] = below(1.0 / 3), x_[d] = below(2.0 / 3);
    for (const int32_t v : mesh_.present()) {
        for_ring(v, [&](int32_t g) { measure(g / 3); });
    }
}

// The shape of a face as it is in space, slivers rounded a little, with the area that it stands
// for.
void Embedding::measure(int32_t face) {
    double square[3], mean = 0, sum = 0, squares = 0;
    for (int k = 0; k < 3; ++k) {
        const int32_t h = Hierarchy::next(3 * face + k);
        const Vec side = mesh_.point(mesh_.target(h)) - mesh_.point(mesh_.origin(h));
        square[k] = dot(side, side);
        mean += square[k] / 3;
    }
    for (double& l : square) {
        l = mean > kVanishing ? l / mean + kSliver : 1.0;
        sum += l;
        squares += l * l;
    }
    const double four_areas = std::sqrt(std::max(sum * sum - 2 * squares, 0.0));
    Shape& shape = shape_[face];
    for (int k = 0; k < 3; ++k) shape.cotangent[k] = (sum - 2 * square[k]) / four_areas;
    shape.area = mesh_.area(face);
}

void Embedding::gather(int32_t v) {
    ring_.wedges.clear();
    ring_.desired = desired_.empty() ? nullptr : &desired_[v];
    for_ring(v, [&](int32_t h) {
        const Shape& shape = shape_[h / 3];
        const int32_t to = Hierarchy::next(h), last = Hierarchy::previous(h);
        const Vec &p = x_[mesh_.origin(to)], &q = x_[mesh_.origin(last)];
        const Vec side = q - p;
        ring_.wedges.push_back({p, q, cross(p, side), shape.cotangent[last % 3],
                                shape.cotangent[to % 3], shape.cotangent[h % 3] * dot(side, side),
                                shape.area});
    });
}

// Moves the vertex by a part of Newton's step, or less, if that lessens the energy; whether it did.
bool Embedding::relax(int32_t v, double part) {
    gather(v);
    const Vec x = x_[v];
    const Tangents plane(x);
    const Quadratic model = ring_.expanded(x, plane);
    double e, f;
    if (!model.step(e, f)) return false;
    const double fall = -(e * model.ge + f * model.gf);
    if (!(fall > kSettled * model.value)) return false;
    const Vec step = e * plane.e + f * plane.f;
    double along = ring_.reach(x, step, part);
    for (int halving = 0; halving < 6; ++halving, along /= 2) {
        const Vec to = unit(x + along * step);
        if (ring_.energy(to) < model.value && ring_.clear(to)) {
            x_[v] = to;
            return true;
        }
    }
    return false;
}

// Moves the vertices around which something has changed.
void Embedding::sweep() {
    int64_t count = 0;
    for (const int32_t v : mesh_.present()) {
        if (count++ % 65536 == 0) check_interrupt();
        if (!awake_[v]) continue;
        awake_[v] = 0;
        if (!relax(v, kOver)) continue;
        awake_[v] = 1;
        for_ring(v, [&](int32_t h) { awake_[mesh_.target(h)] = 1; });
    }
}

// Leaves of the part what is on the inner side of one side of the ring.
void Embedding::clip(size_t s) {
    const Vec &from = corner_[s], &to = corner_[(s + 1) % corner_.size()];
    const auto height = [&](const Vec& p) { return p == from || p == to ? 0.0 : dot(side_[s], p); };
    rest_.clear();
    for (size_t i = 0; i < part_.size(); ++i) {
        const Vec &a = part_[i], &b = part_[(i + 1) % part_.size()];
        const double over_a = height(a), over_b = height(b);
        if (over_a >= 0) rest_.push_back(a);
        if ((over_a > 0 && over_b < 0) || (over_a < 0 && over_b > 0)) {
            rest_.push_back(unit(std::abs(over_b) * a + std::abs(over_a) * b));
        }
    }
    part_.swap(rest_);
}

// The centre of the directions on the inner side of all sides of the ring, which is star-shaped
// from its first vertex: each triangle of its fan is clipped by the sides, as a cone.
bool Embedding::kernel_centre(Vec& centre) {
    const Vec& u = ring_.wedges[0].p;
    const Tangents plane(u);
    const size_t n = ring_.wedges.size();
    corner_.clear();
    side_.clear();
    for (const Wedge& w : ring_.wedges) {  // seen from u, so that small rings keep their digits
        const Vec from = w.p - u;
        corner_.push_back({dot(from, plane.e), dot(from, plane.f), 1 + dot(from, u)});
    }
    for (size_t k = 0; k < n; ++k) side_.push_back(cross(corner_[k], corner_[(k + 1) % n]));
    Vec sum{0, 0, 0};
    for (size_t k = 1; k + 1 < n; ++k) {
        part_ = {corner_[0], corner_[k], corner_[k + 1]};
        for (size_t s = 0; s < n && part_.size() >= 3; ++s) {
            if (s != k) clip(s);
        }
        for (size_t i = 1; i + 1 < part_.size(); ++i) {
            const Vec &a = part_[0], &b = part_[i], &c = part_[i + 1];
            sum = sum + length(cross(b - a, c - a)) * (a + b + c);
        }
    }
    if (!(length(sum) > 0)) return false;
    centre = unit(sum[2] * u + sum[0] * plane.e + sum[1] * plane.f);
    return true;
}

// Finds room for the vertex that comes back next; false if there is none in floating point.
bool Embedding::place(int32_t v) {
    ring_.wedges.clear();
    for (size_t k = 0; k < coming_.size(); ++k) {
        const Vec &p = x_[coming_[k]], &q = x_[coming_[(k + 1) % coming_.size()]];
        ring_.wedges.push_back({p, q, cross(p, q - p), 0, 0, 0, 0});
    }
    Vec centre;
    if (!kernel_centre(centre) || !ring_.clear(centre)) return false;
    x_[v] = centre;
    if (desired_.empty()) return true;
    const Vec step = desired_[v] - centre;
    const Vec near = unit(centre + ring_.reach(centre, step, 1) * step);
    if (ring_.clear(near)) x_[v] = near;
    return true;
}

bool Embedding::grow(int sweeps) {
    while (mesh_.level_size() > 0) {
        check_interrupt();
        for (int64_t left = mesh_.level_size(); left > 0; --left) {
            mesh_.coming_ring(coming_);
            const int32_t v = mesh_.coming();
            if (!place(v)) return false;
            mesh_.split();
            awake_[v] = 1;
            for_ring(v, [&](int32_t h) {
                measure(h / 3);
                awake_[mesh_.target(h)] = 1;
            });
            for (int k = 0; k < kPlacing && relax(v, 1); ++k) continue;
        }
        const double finer = double(x_.size()) / double(mesh_.present().size());
        const int many = int(std::min(double(kMostSweeps), sweeps * finer));
        for (int k = 0; k < many; ++k) sweep();
    }
    return true;
}

// Takes vertices all the way to their desired places where that turns no face over.
void Embedding::snap() {
    if (desired_.empty()) return;
    bool moved = true;
    for (int round = 0; moved && round < kSnaps; ++round) {
        check_interrupt();
        moved = false;
        for (const int32_t v : mesh_.present()) {
            if (x_[v] == desired_[v]) continue;
            gather(v);
            if (!ring_.clear(desired_[v])) continue;
            x_[v] = desired_[v];
            moved = true;
        }
    }
}

}  // namespace

std::vector<double> embed_sphere(const double* vertices, int64_t vertex_count, const int32_t* faces,
                                 const int32_t* twins, int64_t face_count, const double* desired,
                                 double area_weight, int sweeps) {
    // Near-conformal weights, or desired places, may leave no room; areas kept do, and so does
    // connectivity alone even where the shape is extreme.
    const double even = std::max(1.0, area_weight);
    struct Attempt {
        const double *vertices, *desired;
        double area_weight;
    };
    for (const Attempt& attempt :
         {Attempt{vertices, desired, area_weight}, Attempt{vertices, nullptr, even},
          Attempt{nullptr, nullptr, even}}) {
        Hierarchy mesh(attempt.vertices, vertex_count, faces, twins, face_count);
        Embedding embedding(mesh, vertex_count, face_count, attempt.desired, attempt.area_weight);
        embedding.lay_tetrahedron();
        if (!embedding.grow(sweeps)) continue;
        embedding.snap();
        std::vector<double> positions;
        positions.reserve(3 * vertex_count);
        for (const Vec& x : embedding.positions()) {
            positions.insert(positions.end(), x.begin(), x.end());
        }
        return positions;
    }
    return {};
}

}  // namespace henkei
