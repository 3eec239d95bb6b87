// What the tracing of a motorcycle graph takes and gives; the method is described in
// motorcycles.cpp.
#pragma once

#include <cstdint>
#include <vector>

namespace henkei {

// A triangulated surface with two coordinates u, v per triangle that fit over every edge up to
// quarter turns. Rows of half-edges, 3 f + i from corner i to corner i + 1 of face f. It grows as
// edges are split; half-edges that start at a vertex keep their number or are told.
struct TracedSurface {
    std::vector<double> vertices;   // (n, 3)
    std::vector<int32_t> faces;     // (m, 3)
    std::vector<int32_t> twin;      // (3 m,), -1 on the boundary
    std::vector<double> change;     // (3 m, 2) of u and v along the half-edge, in its face
    std::vector<int8_t> matching;   // (3 m,) direction k of its face goes on as k + matching
    std::vector<int8_t> track;      // (3 m,) direction along which a track or feature runs, or -1
    std::vector<uint8_t> feature;   // (3 m,)
    std::vector<uint8_t> kept_off;  // (n,) vertices that tracks end at only if they are meant to
};

struct TracingResult {
    TracedSurface surface;
    std::vector<int8_t> turn;  // (3 m,) quarter turns of the rim at the start of a track half-edge
    int64_t motorcycles = 0;   // how many were started
    int64_t merged = 0;        // that ran into a track of their own direction
    int64_t lost = 0;          // that ended where no way ahead was found
};

// starts: pairs (vertex, face): tracks start at the vertex in all directions in which none runs,
// but so that no angle of two quarters is divided; if the face is not -1, in all directions within
// the angle that holds the face, even one of two quarters. meeting: by how many units two lines may
// lie apart whose motorcycles come towards each other and then share one track.
TracingResult trace_motorcycles(TracedSurface surface, const int32_t* starts, int64_t count,
                                double meeting);

}  // namespace henkei
