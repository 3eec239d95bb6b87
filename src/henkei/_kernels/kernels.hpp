// What the kernels offer, over plain arrays; bind.cpp gives them to Python.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace henkei {

// Lets Ctrl-C end a long kernel: takes the GIL for a moment, throws if a signal handler raised.
void check_interrupt();

// Values of `twin` that are not a half-edge.
constexpr int32_t kBoundary = -1, kNotManifold = -2, kNotOriented = -3;

void half_edge_twins(const int32_t* origin, const int32_t* target, int64_t half_edges,
                     int64_t vertices, int32_t* twin);

// Pairs of faces that intersect, as (f0, g0, f1, g1, ...); at most `limit` pairs.
std::vector<int32_t> self_intersections(const double* vertices, int64_t vertex_count,
                                        const int32_t* faces, int64_t face_count, int64_t limit);

// How the adaptation cools: geometrically from start to end over its steps (eq. 9, 10).
struct AdaptationSchedule {
    int64_t steps;
    double rate_start, rate_end;      // how far the winner moves towards the control point
    double radius_start, radius_end;  // reach over the mesh, in edges
    bool literal;                     // the winner is nearest to the plane, not to the point
    int64_t seed;
};

// Moves the vertices x; returns the number of steps without a winner. winners: per control point
// its vertex (a landmark) or -1. low, high: a box around vertices and control points.
int64_t adapt(double* x, int64_t vertices, const int64_t* ring_start, const int32_t* ring,
              const double* points, const double* normals, const int32_t* winners, int64_t count,
              const AdaptationSchedule& schedule, const double* low, const double* high);

// Face and barycentric weights of directions in a triangulated unit sphere.
void locate_on_sphere(const double* x, const int32_t* faces, const int32_t* twins,
                      int64_t face_count, const double* points, int64_t count, int32_t* face,
                      double* weights);

// A model and its target, both on one sphere. frozen: vertices that stay (landmarks).
// on_face: the target's face that holds each vertex.
// controls: points of the target that the model is to cover. rest: the model's own shape.
// guide, trust: where a vertex is expected, and from 0 to 1 how surely. region: of each vertex, or
// -1; outside: per region, the distance of each of the target's vertices from it.
struct RefinementInput {
    using Vec = std::array<double, 3>;
    const Vec *sphere, *rest, *guide;
    const int32_t *faces, *twins, *on_face;
    const double *trust, *outside;
    const int32_t* region;
    const uint8_t* frozen;
    int64_t vertices, faces_count;
    const Vec *target_sphere, *target_x, *target_normals;
    const int32_t *target_faces, *target_twins;
    int64_t target_face_count, target_vertices;
    const Vec *control_sphere, *control_x;
    int64_t controls;
};

// coverage: squared distance of control points, in squared mean edge lengths; worst: its square.
// distortion: of the faces' angles and areas. lean: away from the target's normals. guide: away
// from where vertices are expected, on coarse levels; hold: the same on all, where that is trusted.
// region: distance from the region of the same number.
struct RefinementWeights {
    double coverage, worst, distortion, lean, guide, hold, region;
};

// Who is told how a refinement goes on. done: after each sweep, with about the share of the work,
// from 0 to 1. seen, if anyone looks: with the directions of all vertices, now and then.
struct RefinementReport {
    std::function<void(double)> done;
    std::function<void(const double*)> seen;
};

// Where the vertices end on the sphere, through levels of at least `coarsest` vertices that are
// not frozen.
void refine(const RefinementInput& input, const RefinementWeights& weights, int64_t coarsest,
            int sweeps, const RefinementReport& report, double* sphere);

// Positions (n, 3) on the unit sphere of a closed surface of genus 0; empty if there is no room in
// floating point. desired: directions (n, 3), or null. area_weight: of areas against angles.
std::vector<double> embed_sphere(const double* vertices, int64_t vertex_count, const int32_t* faces,
                                 const int32_t* twins, int64_t face_count, const double* desired,
                                 double area_weight, int sweeps);

// Faces that are not counter-clockwise seen from outside the sphere.
std::vector<int32_t> inverted_on_sphere(const double* positions, const int32_t* faces,
                                        int64_t face_count);

// Patch of each face, grown from one seed face each; -1 where no seed is connected. neighbours: of
// each face over its three edges, -1 where none or where patches must not grow. Per face its unit
// normal and a point, and per patch the same; compactness: of squared distances against normals.
void flood(const int32_t* neighbours, const double* normals, const double* centres, int64_t faces,
           const int32_t* seeds, const double* patch_normals, const double* patch_centres,
           int64_t patches, double compactness, int32_t* label);

}  // namespace henkei
