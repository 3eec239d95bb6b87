// Geometry on the unit sphere, and finding the face that holds a direction.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace henkei {

using Vec = std::array<double, 3>;

inline Vec operator+(const Vec& a, const Vec& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vec operator-(const Vec& a, const Vec& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vec operator*(double s, const Vec& a) {
    return {s * a[0], s * a[1], s * a[2]};
}
inline double dot(const Vec& a, const Vec& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vec cross(const Vec& a, const Vec& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(const Vec& a) {
    return std::sqrt(dot(a, a));
}
inline Vec unit(const Vec& a) {
    const double l = length(a);
    return l > 0 ? (1 / l) * a : a;
}

// Positive where a, b, c run counter-clockwise seen from outside. Taken over differences, which
// keeps the sign of small triangles.
inline double turn(const Vec& a, const Vec& b, const Vec& c) {
    return dot(a, cross(b - a, c - a));
}

// A triangulation of the unit sphere.
struct Sphere {
    const Vec* x;
    const int32_t* faces;
    const int32_t* twins;
    int64_t face_count;

    const Vec& corner(int64_t face, int k) const { return x[faces[3 * face + k]]; }
    // The three signed volumes of p with the edges opposite to the corners; all positive inside.
    Vec sides(int64_t face, const Vec& p) const {
        const Vec &a = corner(face, 0), &b = corner(face, 1), &c = corner(face, 2);
        return {turn(p, b, c), turn(p, c, a), turn(p, a, b)};
    }
};

// The face of the sphere that holds the direction p, walked to from a face near it, and the weights
// of its corners; where rounding hides it, the face that p is least outside of.
int64_t locate(const Sphere& sphere, const Vec& p, int64_t near, Vec& weights);

}  // namespace henkei
