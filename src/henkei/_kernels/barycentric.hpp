// Barycentric coordinates of places on a triangulation (4.5 and eq. 7 of the paper that overlay.cpp
// names).
#pragma once

#include <algorithm>

#include "triangulation.hpp"
#include "walk.hpp"

namespace henkei {

// A point at the part `along` of a half-edge.
inline void weigh_edge(const SortedMesh& mesh, int32_t h, double along, int32_t* face,
                       double* bary) {
    *face = mesh.face_name[h / 3];
    bary[0] = bary[1] = bary[2] = 0;
    bary[h % 3] = 1 - along;
    bary[next(h) % 3] = along;
}

// Weights of a place on a mesh (4.5, eq. 7).
inline void weigh(const SortedMesh& mesh, Place place, PlanePoint p, int32_t* face, double* bary) {
    bary[0] = bary[1] = bary[2] = 0;
    if (place.kind == Place::kVertex) {
        const int32_t h = mesh.leaving(place.id);
        *face = mesh.face_name[h / 3];
        bary[h % 3] = 1;
    } else if (place.kind == Place::kEdge) {
        const PlanePoint from = mesh.from(place.id), to = mesh.to(place.id);
        const double along =
            double(Wide(p.x - from.x) * (to.x - from.x) + Wide(p.y - from.y) * (to.y - from.y)) /
            double(Wide(to.x - from.x) * (to.x - from.x) + Wide(to.y - from.y) * (to.y - from.y));
        weigh_edge(mesh, place.id, along, face, bary);
    } else {
        *face = mesh.face_name[place.id];
        const int32_t h = 3 * place.id;
        const Wide whole = area(mesh.from(h), mesh.to(h), mesh.from(h + 2));
        for (int i = 0; i < 3; ++i) {
            const Wide part = area(mesh.from(next(h + i)), mesh.from(prev(h + i)), p);
            bary[i] = std::max(0.0, double(part) / double(whole));
        }
        const double sum = bary[0] + bary[1] + bary[2];
        for (int i = 0; i < 3; ++i) bary[i] /= sum;
    }
}

}  // namespace henkei
