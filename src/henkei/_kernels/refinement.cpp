// Refinement of a registration: the vertices of the model glide over the target until the model
// covers it.
// S. Matsui, K. Morooka, H. Nagahashi, "3-D morphing by direct mapping between mesh models using
// Self-organizing Deformable Model", algorithm 1, steps 9 to 11 (eq. 5, 12, 13): a vertex tries
// places towards the control points assigned to it and takes the one of least energy. Here both
// surfaces lie on one sphere: a place is a direction, the control points of a face are those inside
// it on the sphere, and a move that turns a face over there is never made. The energy adds to the
// distance of the control points the distortion of faces (of angles, as in K. Hormann, G. Greiner,
// "MIPS: an efficient global parametrization method", 2000, and of areas) and their leaning away
// from the target's normals. All this is done on coarse versions of the model first.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "coarsening.hpp"
#include "kernels.hpp"
#include "sphere.hpp"

namespace henkei {
namespace {

constexpr double kArea = 0.2;  // what areas count against angles in the distortion of a face
constexpr double kMore = 0.3;  // coarser levels get more sweeps, by this power of their coarseness
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double squared_distance(const Vec& p, const Vec& a, const Vec& b, const Vec& c) {
    const Vec ab = b - a, ac = c - a, ap = p - a;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    const auto from = [&](const Vec& q) { return dot(p - q, p - q); };
    if (d1 <= 0 && d2 <= 0) return dot(ap, ap);
    const Vec bp = p - b;
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return dot(bp, bp);
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return from(a + (d1 / (d1 - d3)) * ab);
    const Vec cp = p - c;
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return dot(cp, cp);
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return from(a + (d2 / (d2 - d6)) * ac);
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6) {
        return from(b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b));
    }
    const Vec n = cross(ab, ac);
    const double nn = dot(n, n), height = dot(n, ap);
    return nn > 0 ? height * height / nn : dot(ap, ap);
}

// A face of the model at rest, in its plane: (0, 0), (base, 0), (shift, height); slivers are given
// some height. first: the corner at (0, 0).
struct Rest {
    int first;
    double base, shift, height;
    double area() const { return base * height / 2; }
};

Rest rest_of(const Vec& a, const Vec& b, const Vec& c, double shortest) {
    constexpr double kFlattest = 0.05;
    const Vec corner[3] = {a, b, c};
    Rest rest{0, -1, 0, 0};
    for (int k = 0; k < 3; ++k) {
        const double l = length(corner[(k + 1) % 3] - corner[k]);
        if (l > rest.base) rest.base = l, rest.first = k;
    }
    const Vec e = corner[(rest.first + 1) % 3] - corner[rest.first];
    const Vec d = corner[(rest.first + 2) % 3] - corner[rest.first];
    rest.shift = rest.base > 0 ? dot(e, d) / rest.base : 0;
    rest.height = rest.base > 0 ? length(cross(e, d)) / rest.base : 0;
    rest.base = std::max(rest.base, shortest);
    rest.height = std::max(rest.height, kFlattest * rest.base);
    return rest;
}

struct Place {
    Vec direction, x, normal;
    int32_t face;
    Vec weights;
};

class Refinement {
  public:
    Refinement(const RefinementInput& in, const RefinementWeights& weights)
        : in_(in),
          w_(weights),
          target_{in.target_sphere, in.target_faces, in.target_twins, in.target_face_count},
          place_(in.vertices),
          first_(in.vertices + 1, 0),
          star_(3 * in.faces_count),
          rest_(in.faces_count),
          control_face_(in.controls, -1),
          control_next_(in.controls, -1),
          control_head_(in.faces_count, -1),
          control_distance_(in.controls, 0.0),
          reach_(in.vertices, 0.25),
          awake_(in.vertices, 1) {
        for (int64_t h = 0; h < 3 * in.faces_count; ++h) ++first_[in.faces[h] + 1];
        for (int64_t v = 0; v < in.vertices; ++v) first_[v + 1] += first_[v];
        std::vector<int64_t> at(first_.begin(), first_.end() - 1);
        for (int64_t h = 0; h < 3 * in.faces_count; ++h) star_[at[in.faces[h]]++] = int32_t(h);
        const double shortest = 1e-3 / std::sqrt(double(in.vertices));
        double area = 0;
        for (int64_t f = 0; f < in.faces_count; ++f) {
            const int32_t* c = in.faces + 3 * f;
            rest_[f] = rest_of(in.rest[c[0]], in.rest[c[1]], in.rest[c[2]], shortest);
            area += rest_[f].area();
        }
        for (Rest& r : rest_) {
            r.base /= std::sqrt(area), r.shift /= std::sqrt(area), r.height /= std::sqrt(area);
        }
        for (int64_t v = 0; v < in.vertices; ++v) {
            place_[v].face = in.on_face[v];
            set(place_[v], in.sphere[v]);
        }
        // The control points come in no order: each is looked for from its own part of the sphere.
        std::vector<int32_t> within(in.controls);
        std::vector<double> weights_in(3 * in.controls);
        locate_on_sphere(in.sphere[0].data(), in.faces, in.twins, in.faces_count,
                         in.control_sphere[0].data(), in.controls, within.data(),
                         weights_in.data());
        for (int64_t c = 0; c < in.controls; ++c) put(int32_t(c), within[c]);
        for (int64_t c = 0; c < in.controls; ++c) {
            const int32_t* f = in.faces + 3 * int64_t(control_face_[c]);
            control_distance_[c] =
                squared_distance(in.control_x[c], place_[f[0]].x, place_[f[1]].x, place_[f[2]].x);
        }
    }

    // One pass over the vertices; returns how many moved.
    int64_t sweep(bool backwards) {
        int64_t moved = 0;
        for (int64_t i = 0; i < in_.vertices; ++i) {
            if ((i & 0x3FF) == 0) check_interrupt();
            const int64_t v = backwards ? in_.vertices - 1 - i : i;
            if (in_.frozen[v] || !awake_[v]) continue;
            if (improve(int32_t(v))) {
                ++moved;
                for (int64_t s = first_[v]; s < first_[v + 1]; ++s) {
                    awake_[after(star_[s])] = 1;
                }
            } else if (reach_[v] < 0.01) {
                awake_[v] = 0;
            }
        }
        return moved;
    }

    const Place& place(int64_t v) const { return place_[v]; }

  private:
    int32_t after(int32_t h) const { return in_.faces[h % 3 == 2 ? h - 2 : h + 1]; }
    int32_t before(int32_t h) const { return in_.faces[h % 3 == 0 ? h + 2 : h - 1]; }

    void put(int32_t control, int32_t face) {
        control_face_[control] = face;
        control_next_[control] = control_head_[face];
        control_head_[face] = control;
    }

    void set(Place& place, const Vec& direction) const {
        place.direction = direction;
        place.face = int32_t(locate(target_, direction, place.face, place.weights));
        place.x = place.normal = {0, 0, 0};
        for (int k = 0; k < 3; ++k) {
            const int32_t t = in_.target_faces[3 * int64_t(place.face) + k];
            place.x = place.x + place.weights[k] * in_.target_x[t];
            place.normal = place.normal + place.weights[k] * in_.target_normals[t];
        }
    }

    // Distortion and leaning of the face of half-edge h, its corner at h placed at p.
    double face_energy(int32_t h, const Place& p) const {
        const int64_t f = h / 3;
        const Rest& r = rest_[f];
        const Place* corner[3];
        for (int k = 0; k < 3; ++k) corner[k] = &place_[in_.faces[3 * f + k]];
        corner[h % 3] = &p;
        const Place &a = *corner[r.first], &b = *corner[(r.first + 1) % 3],
                    &c = *corner[(r.first + 2) % 3];
        const Vec e = b.x - a.x, d = c.x - a.x, n = cross(e, d);
        const double size = length(n);
        if (!(size > 0)) return kInfinity;
        const Vec across = d - (r.shift / r.base) * e;
        const double stretch =
            dot(e, e) / (r.base * r.base) + dot(across, across) / (r.height * r.height);
        const double ratio = std::max(size / (2 * r.area()), 1e-6);
        const double distortion = stretch / (2 * ratio) - 1 + kArea * (ratio + 1 / ratio - 2);
        const Vec m = a.normal + b.normal + c.normal;
        const double upright = dot(n, m) / (size * std::max(length(m), 1e-300));
        const double lean = std::max(0.0, 0.5 - upright);
        const double share = r.area() + size / 2;
        return share * (w_.distortion * distortion + w_.lean * lean * lean);
    }

    // Being away from where the vertex is expected, and outside of its region.
    double place_energy(int32_t v, const Place& p) const {
        const Vec away = p.x - in_.guide[v];
        const double trust = in_.trust[v];
        const double pull = w_.hold * trust + w_.guide * (1 - trust) / double(in_.vertices);
        if (in_.region[v] < 0) return pull * dot(away, away);
        const double* distance = in_.outside + int64_t(in_.region[v]) * in_.target_vertices;
        double out = 0;
        for (int k = 0; k < 3; ++k) {
            out += p.weights[k] * distance[in_.target_faces[3 * int64_t(p.face) + k]];
        }
        return pull * dot(away, away) + w_.region * out * out;
    }

    double distance_energy(double squared) const {
        const double relative = squared * double(in_.vertices);
        return w_.coverage * (relative + w_.worst * relative * relative) / double(in_.controls);
    }

    void gather(int32_t v) {
        controls_.clear();
        for (int64_t s = first_[v]; s < first_[v + 1]; ++s) {
            for (int32_t c = control_head_[star_[s] / 3]; c >= 0; c = control_next_[c]) {
                controls_.push_back(c);
            }
        }
    }

    double energy_here(int32_t v) const {
        double sum = place_energy(v, place_[v]);
        for (int64_t s = first_[v]; s < first_[v + 1]; ++s) sum += face_energy(star_[s], place_[v]);
        for (int32_t c : controls_) sum += distance_energy(control_distance_[c]);
        return sum;
    }

    // Whether no face turns over, nor gets flatter than it is and than kFlat.
    bool upright(int32_t v, const Vec& direction) const {
        constexpr double kFlat = 1e-6;
        for (int64_t s = first_[v]; s < first_[v + 1]; ++s) {
            const Vec &j = place_[after(star_[s])].direction,
                      &k = place_[before(star_[s])].direction;
            const Vec e = j - direction, d = k - direction;
            const double size = std::sqrt(std::max(dot(e, e), dot(d, d)));
            const double now = turn(direction, j, k);
            if (now > 1e-14 * size + kFlat * size * size) continue;
            if (!(now > 1e-15 * size && now > turn(place_[v].direction, j, k))) return false;
        }
        return true;
    }

    // Energy of the star of v with v in another place; infinite where a face would turn over.
    // Stops when above `limit`. Leaves in faces_ and distances_ where the controls would go.
    double energy_at(int32_t v, const Place& p, double limit) {
        double sum = place_energy(v, p);
        for (int64_t s = first_[v]; s < first_[v + 1]; ++s) {
            sum += face_energy(star_[s], p);
            if (sum >= limit) return kInfinity;
        }
        faces_.resize(controls_.size());
        distances_.resize(controls_.size());
        for (size_t i = 0; i < controls_.size(); ++i) {
            const Vec& q = in_.control_sphere[controls_[i]];
            int32_t best = -1;
            double most = -kInfinity;
            for (int64_t s = first_[v]; s < first_[v + 1]; ++s) {
                const Vec& j = place_[after(star_[s])].direction;
                const Vec& k = place_[before(star_[s])].direction;
                const double one = turn(p.direction, j, q), two = turn(k, p.direction, q);
                const double least =
                    std::min(one / length(j - p.direction), two / length(k - p.direction));
                if (least > most) most = least, best = star_[s];
                if (most >= 0) break;
            }
            faces_[i] = best / 3;
            distances_[i] = squared_distance(in_.control_x[controls_[i]], p.x,
                                             place_[after(best)].x, place_[before(best)].x);
            sum += distance_energy(distances_[i]);
            if (sum >= limit) return kInfinity;
        }
        return sum;
    }

    bool improve(int32_t v) {
        gather(v);
        best_energy_ = energy_here(v) * (1 - 1e-4);
        found_ = false;
        const Vec here = place_[v].direction;
        Vec centre = {0, 0, 0};
        double size = 0;
        int worst = -1;
        for (int64_t s = first_[v]; s < first_[v + 1]; ++s) {
            const Vec& j = place_[after(star_[s])].direction;
            centre = centre + j;
            size += length(j - here);
        }
        const double edge = size / double(first_[v + 1] - first_[v]);
        centre = unit(centre);
        double far = 0, near = kInfinity;
        int nearest = -1;
        for (size_t i = 0; i < controls_.size(); ++i) {
            const int32_t c = controls_[i];
            if (control_distance_[c] > far) far = control_distance_[c], worst = c;
            const Vec away = in_.control_sphere[c] - here;
            const double d = dot(away, away);
            if (d < near) near = d, nearest = c;
        }
        // eq. 12: towards control points
        if (worst >= 0) {
            attempt(v, in_.control_sphere[worst]);
            attempt(v, unit(here + in_.control_sphere[worst]));
        }
        if (nearest >= 0 && nearest != worst) attempt(v, in_.control_sphere[nearest]);
        attempt(v, unit(here + centre));
        // Along two directions of the tangent plane, at a step that adapts to success.
        const Vec axis = std::abs(here[0]) < 0.6 ? Vec{1, 0, 0} : Vec{0, 1, 0};
        const Vec u = unit(cross(here, axis)), t = cross(here, u);
        const double step = reach_[v] * edge;
        bool some = false;
        for (int k = 0; k < 4; ++k) {
            const double along = (k & 1 ? -1 : 1) * step;
            some |= attempt(v, unit(here + along * (k & 2 ? t : u)));
        }
        reach_[v] = some ? std::min(reach_[v] * 1.5, 0.5) : reach_[v] * 0.5;
        if (!found_) return false;
        take(v);
        return true;
    }

    bool attempt(int32_t v, const Vec& direction) {
        if (!upright(v, direction)) return false;
        Place p = place_[v];
        set(p, direction);
        const double energy = energy_at(v, p, best_energy_);
        if (!(energy < best_energy_)) return false;
        best_energy_ = energy;
        best_ = p;
        best_faces_ = faces_;
        best_distances_ = distances_;
        return found_ = true;
    }

    void take(int32_t v) {
        place_[v] = best_;
        for (int64_t s = first_[v]; s < first_[v + 1]; ++s) control_head_[star_[s] / 3] = -1;
        for (size_t i = 0; i < controls_.size(); ++i) {
            put(controls_[i], best_faces_[i]);
            control_distance_[controls_[i]] = best_distances_[i];
        }
    }

    const RefinementInput& in_;
    const RefinementWeights w_;
    const Sphere target_;
    std::vector<Place> place_;
    std::vector<int64_t> first_;
    std::vector<int32_t> star_;  // half-edges that start at each vertex
    std::vector<Rest> rest_;
    std::vector<int32_t> control_face_, control_next_, control_head_;
    std::vector<double> control_distance_, reach_;
    std::vector<uint8_t> awake_;
    std::vector<int32_t> controls_, faces_, best_faces_;
    std::vector<double> distances_, best_distances_;
    Place best_;
    double best_energy_ = 0;
    bool found_ = false;
};

// One level: its vertices under numbers of their own, and the arrays that go with them.
struct Level {
    std::vector<int32_t> own, faces, twins, on_face, region;
    std::vector<Vec> sphere, rest, guide, control_sphere, control_x;
    std::vector<double> trust;
    std::vector<uint8_t> frozen;

    Level(const RefinementInput& in, const Coarsening& mesh, const std::vector<Vec>& placed)
        : own(mesh.vertices()), faces(mesh.faces()) {
        std::vector<int32_t> number(in.vertices, -1);
        for (size_t i = 0; i < own.size(); ++i) {
            const int32_t v = own[i];
            number[v] = int32_t(i);
            sphere.push_back(placed[v]);
            rest.push_back(in.rest[v]);
            frozen.push_back(in.frozen[v]);
            guide.push_back(in.guide[v]);
            trust.push_back(in.trust[v]);
            region.push_back(in.region[v]);
        }
        std::vector<int32_t> origin, target;
        for (size_t h = 0; h < faces.size(); ++h) {
            origin.push_back(faces[h] = number[faces[h]]);
        }
        for (size_t h = 0; h < faces.size(); ++h)
            target.push_back(faces[h % 3 == 2 ? h - 2 : h + 1]);
        twins.resize(faces.size());
        half_edge_twins(origin.data(), target.data(), int64_t(faces.size()), int64_t(own.size()),
                        twins.data());
        on_face.resize(own.size());
        std::vector<double> weights(3 * own.size());
        locate_on_sphere(in.target_sphere[0].data(), in.target_faces, in.target_twins,
                         in.target_face_count, sphere[0].data(), int64_t(own.size()),
                         on_face.data(), weights.data());
        const int64_t step =
            std::max<int64_t>(1, in.controls / (kControlsPerVertex * int64_t(own.size()) + 500));
        for (int64_t c = 0; c < in.controls; c += step) {
            control_sphere.push_back(in.control_sphere[c]);
            control_x.push_back(in.control_x[c]);
        }
    }

    RefinementInput input(const RefinementInput& in) const {
        RefinementInput level = in;
        level.sphere = sphere.data(), level.rest = rest.data(), level.guide = guide.data();
        level.trust = trust.data(), level.region = region.data();
        level.faces = faces.data(), level.twins = twins.data(), level.on_face = on_face.data();
        level.frozen = frozen.data();
        level.vertices = int64_t(own.size()), level.faces_count = int64_t(faces.size() / 3);
        level.control_sphere = control_sphere.data(), level.control_x = control_x.data();
        level.controls = int64_t(control_x.size());
        return level;
    }

    static constexpr int64_t kControlsPerVertex = 5;
};

// Shows where all vertices are while a level is refined: not often, nor for much of the time.
class Window {
  public:
    explicit Window(const RefinementReport& report) : report_(report) {}

    bool due() const { return report_.seen && Clock::now() >= next_; }

    // The vertices that are away are put back for the look.
    void show(Coarsening mesh, std::vector<Vec> sphere) {
        const auto start = Clock::now();
        while (mesh.rounds() > 0) mesh.refine(sphere);
        report_.seen(sphere[0].data());
        const auto end = Clock::now();
        next_ = end + std::max<Clock::duration>(kPause, kPatience * (end - start));
    }

  private:
    using Clock = std::chrono::steady_clock;
    static constexpr std::chrono::milliseconds kPause{100};
    static constexpr int kPatience = 10;  // times what a look took

    const RefinementReport& report_;
    Clock::time_point next_{};
};

// The work on one level, as shares of the whole.
struct Span {
    double start, end;
};

// Sweeps over one level; writes where its vertices are now.
void sweep_level(const RefinementInput& in, const RefinementWeights& weights,
                 const Coarsening& mesh, int sweeps, std::vector<Vec>& sphere,
                 const RefinementReport& report, Window& window, Span span) {
    const Level level(in, mesh, sphere);
    const RefinementInput input = level.input(in);
    const double coarser = double(in.vertices) / double(input.vertices);
    RefinementWeights w = weights;
    w.distortion *= coarser;
    w.guide *= std::pow(coarser * 100 / double(in.vertices), 1.5);
    Refinement refinement(input, w);
    const int more = int(std::min(double(sweeps) * std::pow(coarser, kMore), 300.0));
    const auto put = [&] {
        for (size_t i = 0; i < level.own.size(); ++i) {
            sphere[level.own[i]] = refinement.place(int64_t(i)).direction;
        }
    };
    for (int s = 0; s < more; ++s) {
        const int64_t moved = refinement.sweep(s % 2 == 1);
        report.done(span.start + (span.end - span.start) * (s + 1) / more);
        if (window.due()) {
            put();
            window.show(mesh, sphere);
        }
        if (moved == 0) break;
    }
    put();
}

}  // namespace

void refine(const RefinementInput& in, const RefinementWeights& weights, int64_t coarsest,
            int sweeps, const RefinementReport& report, double* placed) {
    constexpr double kDown = 0.1;  // of the work, on the way to the coarsest level
    std::vector<Vec> sphere(in.sphere, in.sphere + in.vertices);
    Coarsening mesh(in.faces, in.faces_count, in.vertices);
    Window window(report);
    double done = 0;
    const auto sweep = [&](int count, double until) {
        sweep_level(in, weights, mesh, count, sphere, report, window, {done, until});
        done = until;
    };
    const auto left = [&] { return double(mesh.vertex_count()) / double(in.vertices); };
    const int64_t frozen = std::count(in.frozen, in.frozen + in.vertices, uint8_t(1));
    while (mesh.vertex_count() - frozen > coarsest) {
        const int64_t taken = mesh.coarsen(sphere, in.rest, in.frozen);
        if (taken == 0) break;
        sweep(2, kDown * (1 - left()));
        if (taken < (mesh.vertex_count() - frozen) / 50) break;
    }
    // Levels of which each is by one factor finer, with sweeps as in sweep_level.
    const auto up = [&] { return kDown + (1 - kDown) * std::pow(left(), 1 - kMore); };
    sweep(sweeps, up());
    while (mesh.rounds() > 0) {
        mesh.refine(sphere);
        sweep(sweeps, up());
    }
    std::copy(sphere[0].data(), sphere[0].data() + 3 * in.vertices, placed);
}

}  // namespace henkei
