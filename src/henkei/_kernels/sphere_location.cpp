// Finding directions in a triangulated sphere by walking from face to face.
// O. Devillers, S. Pion, M. Teillaud, "Walking in a triangulation", 2002: the walk leaves a face
// through an edge that separates it from the goal; trying the edges in a varying order, it cannot
// run in circles for ever.
#include <algorithm>

#include "kernels.hpp"
#include "sphere.hpp"

namespace henkei {
namespace {

// Weights of the point in which the ray along p meets the plane of the face, none negative.
Vec inside_weights(const Vec& sides) {
    Vec w = {std::max(sides[0], 0.0), std::max(sides[1], 0.0), std::max(sides[2], 0.0)};
    const double sum = w[0] + w[1] + w[2];
    if (!(sum > 0)) return {1, 0, 0};
    return {w[0] / sum, w[1] / sum, w[2] / sum};
}

int64_t least_outside(const Sphere& sphere, const Vec& p) {
    int64_t best = 0;
    double most = -INFINITY;
    for (int64_t f = 0; f < sphere.face_count; ++f) {
        const Vec s = sphere.sides(f, p);
        const double scale = std::abs(s[0]) + std::abs(s[1]) + std::abs(s[2]);
        const double margin = scale > 0 ? std::min({s[0], s[1], s[2]}) / scale : -1.0;
        if (margin > most) most = margin, best = f;
    }
    return best;
}

}  // namespace

int64_t locate(const Sphere& sphere, const Vec& p, int64_t near, Vec& weights) {
    int64_t face = near;
    const int64_t limit = 64 + 8 * int64_t(std::sqrt(double(sphere.face_count)));
    for (int64_t step = 0; step < limit; ++step) {
        const Vec s = sphere.sides(face, p);
        int leave = -1;
        for (int k = 0; k < 3 && leave < 0; ++k) {
            const int side = int((k + step) % 3);
            if (s[side] < 0) leave = side;
        }
        if (leave < 0) {
            if (s[0] + s[1] + s[2] > 0) {
                weights = inside_weights(s);
                return face;
            }
            leave = int(step % 3);  // p is seen through the sphere, from behind
        }
        // The edge opposite to corner k starts at corner k + 1.
        face = sphere.twins[3 * face + (leave + 1) % 3] / 3;
    }
    face = least_outside(sphere, p);
    weights = inside_weights(sphere.sides(face, p));
    return face;
}

void locate_on_sphere(const double* x, const int32_t* faces, const int32_t* twins,
                      int64_t face_count, const double* points, int64_t count, int32_t* face,
                      double* weights) {
    const Sphere sphere{reinterpret_cast<const Vec*>(x), faces, twins, face_count};
    // Some face near each cell of a cube around the sphere, to start from.
    const int cells = int(std::clamp(std::sqrt(double(face_count) / 12), 1.0, 128.0));
    const auto cell_of = [&](const Vec& p) {
        int axis = 0;
        for (int k = 1; k < 3; ++k) {
            if (std::abs(p[k]) > std::abs(p[axis])) axis = k;
        }
        const double size = std::max(std::abs(p[axis]), 1e-300);
        const auto place = [&](double value) {
            return std::clamp(int((value / size + 1) / 2 * cells), 0, cells - 1);
        };
        const int side = 2 * axis + (p[axis] < 0);
        return (side * cells + place(p[(axis + 1) % 3])) * cells + place(p[(axis + 2) % 3]);
    };
    std::vector<int32_t> seed(size_t(6 * cells * cells), 0);
    for (int64_t f = face_count - 1; f >= 0; --f) {
        seed[cell_of(sphere.corner(f, 0) + sphere.corner(f, 1) + sphere.corner(f, 2))] = int32_t(f);
    }
    for (int64_t i = 0; i < count; ++i) {
        if ((i & 0xFFFF) == 0) check_interrupt();
        const Vec p = reinterpret_cast<const Vec*>(points)[i];
        Vec w;
        face[i] = int32_t(locate(sphere, p, seed[cell_of(p)], w));
        std::copy(w.begin(), w.end(), weights + 3 * i);
    }
}

}  // namespace henkei
