// A vertex on the sphere between its neighbours: how much the faces around it are distorted, and
// how far it may go. The distortion is that of P. Degener, J. Meseth, R. Klein, "An Adaptable
// Surface Parameterization Method", 2003: (s/t + t/s) (st + 1/(st))^w over the singular values s, t
// of the map of each face; for w = 1 it is the symmetric Dirichlet energy. Inverted faces are
// infinitely bad.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "sphere.hpp"

namespace henkei {

// An orthonormal frame of the plane that touches the sphere at x.
struct Tangents {
    Vec e, f;

    explicit Tangents(const Vec& x) {
        int thin = 0;
        for (int k = 1; k < 3; ++k) thin = std::abs(x[k]) < std::abs(x[thin]) ? k : thin;
        Vec axis{0, 0, 0};
        axis[thin] = 1;
        e = unit(cross(x, axis));
        f = cross(x, e);
    }
};

// Value, gradient and Hessian of a function of two variables.
struct Quadratic {
    double value = 0, ge = 0, gf = 0, hee = 0, hef = 0, hff = 0;

    // Newton's step, the eigenvalues of the Hessian made positive; false if there is none.
    bool step(double& se, double& sf) const {
        const double mean = (hee + hff) / 2, half = (hee - hff) / 2;
        const double radius = std::sqrt(half * half + hef * hef);
        const double high = std::abs(mean + radius), low = std::abs(mean - radius);
        const double least = 1e-6 * std::max(high, low);
        if (!(least > 0) || !std::isfinite(least)) return false;
        const double angle = 0.5 * std::atan2(hef, half);  // of the first eigenvector
        const double c = std::cos(angle), s = std::sin(angle);
        const double a = (c * ge + s * gf) / std::max(high, least);
        const double b = (c * gf - s * ge) / std::max(low, least);
        se = s * b - c * a;
        sf = -s * a - c * b;
        return true;
    }
};

// A face around a vertex v: with the neighbours p, q, counter-clockwise.
struct Wedge {
    Vec p, q;
    Vec normal;         // p x q: the volume of v, p, q is its product with v - p
    double to_p, to_q;  // weights of |v - p|^2, |v - q|^2
    double rest;        // weighted |p - q|^2
    double area;
};

struct SphereRing {
    static constexpr double kClear = 1e-13;  // least volume of a face, by two of its sides
    static constexpr double kGuard = 0.9;    // of the way to turning a face over
    static constexpr double kPull = 30;      // weight of squared distances to desired places

    std::vector<Wedge> wedges;
    double area_weight = 1;
    const Vec* desired = nullptr;  // where the vertex is wanted, if anywhere

    // Sum over the faces around v of area (n / d) (r + 1/r)^w, where d is the volume with the
    // sphere's centre, r = d / (2 area), and n / d is the sum of the ratios of the singular values.
    double energy(const Vec& x) const {
        double sum = 0;
        for (const Wedge& w : wedges) {
            const Vec from_p = x - w.p, from_q = x - w.q;
            const double d = dot(from_p, w.normal);
            if (!(d > 0)) return INFINITY;
            const double n = w.to_p * dot(from_p, from_p) + w.to_q * dot(from_q, from_q) + w.rest;
            const double r = d / (2 * w.area), both = r + 1 / r;
            sum += w.area * n / d * (area_weight == 1 ? both : std::pow(both, area_weight));
        }
        if (desired != nullptr) {
            const Vec away = x - *desired;
            sum += kPull * dot(away, away);
        }
        return sum;
    }

    // The energy around x, over its tangent plane.
    Quadratic expanded(const Vec& x, const Tangents& plane) const {
        Quadratic sum;
        double outward = 0, round = 0;
        for (const Wedge& w : wedges) {
            const Vec from_p = x - w.p, from_q = x - w.q;
            const double d = dot(from_p, w.normal);
            const double n = w.to_p * dot(from_p, from_p) + w.to_q * dot(from_q, from_q) + w.rest;
            const double r = d / (2 * w.area), both = r + 1 / r;
            const double phi = w.area / d * (area_weight == 1 ? both : std::pow(both, area_weight));
            // phi' / phi and phi'' / phi
            const double beta = (r * r - 1) / (r * r + 1), alpha = area_weight * beta - 1;
            const double first = alpha / d;
            const double second =
                (alpha * alpha - alpha + area_weight * (1 - beta * beta)) / (d * d);
            const Vec dn = 2.0 * (w.to_p * from_p + w.to_q * from_q);
            const double ne = dot(dn, plane.e), nf = dot(dn, plane.f);
            const double de = dot(w.normal, plane.e), df = dot(w.normal, plane.f);
            sum.value += phi * n;
            sum.ge += phi * (ne + n * first * de);
            sum.gf += phi * (nf + n * first * df);
            outward += phi * (dot(dn, x) + n * first * dot(w.normal, x));
            round += 2 * phi * (w.to_p + w.to_q);
            sum.hee += phi * (2 * first * ne * de + n * second * de * de);
            sum.hef += phi * (first * (ne * df + nf * de) + n * second * de * df);
            sum.hff += phi * (2 * first * nf * df + n * second * df * df);
        }
        if (desired != nullptr) {
            const Vec away = x - *desired;
            sum.value += kPull * dot(away, away);
            sum.ge += 2 * kPull * dot(away, plane.e);
            sum.gf += 2 * kPull * dot(away, plane.f);
            outward += 2 * kPull * dot(away, x);
            round += 2 * kPull;
        }
        sum.hee += round - outward;  // the sphere bends away from the plane
        sum.hff += round - outward;
        return sum;
    }

    // Whether all faces around are upright beyond doubt of rounding with the centre vertex at x.
    bool clear(const Vec& x) const {
        for (const Wedge& w : wedges) {
            const Vec from_p = x - w.p, from_q = x - w.q;
            const double least = kClear * std::sqrt(dot(from_p, from_p) * dot(from_q, from_q));
            if (!(turn(x, w.p, w.q) > least) || !(dot(from_p, w.normal) > 0)) return false;
        }
        return true;
    }

    // How far along the step, at most `most`, all faces stay upright with something to spare.
    double reach(const Vec& from, const Vec& step, double most) const {
        double longest = most;
        for (const Wedge& w : wedges) {
            const double fall = -dot(step, w.normal);
            if (fall > 0) longest = std::min(longest, kGuard * dot(from - w.p, w.normal) / fall);
        }
        return longest;
    }
};

}  // namespace henkei
