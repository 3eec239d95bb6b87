// A triangulation as the kernels walk it: sorted in space, so that neighbours lie close in memory
// whatever the order of the input.
#pragma once

#include <algorithm>
#include <cstdint>

#include "memory.hpp"
#include "plane.hpp"

namespace henkei {

// Triangles over integer points, all positive, with the twin of each half-edge (-1: boundary).
// Half-edge h runs from corner h of `faces` to the next corner of the same face.
struct Triangulation {
    const PlanePoint* points;
    const int32_t* faces;
    const int32_t* twins;
    int64_t vertex_count, face_count;
};

inline int32_t next(int32_t h) {
    return h % 3 == 2 ? h - 2 : h + 1;
}
inline int32_t prev(int32_t h) {
    return h % 3 == 0 ? h + 2 : h - 1;
}

class SortedMesh {
  public:
    int64_t vertex_count, face_count;
    Array<int32_t> vertex_name, face_name;  // what each vertex and face is called in the input
    Array<int32_t> vertex_number;           // and back

    explicit SortedMesh(const Triangulation& t)
        : vertex_count(t.vertex_count), face_count(t.face_count) {
        sort_faces(t);
        number_vertices(t);
        link(t);
    }

    int32_t origin(int32_t h) const { return faces[h]; }
    int32_t target(int32_t h) const { return faces[next(h)]; }
    PlanePoint point(int32_t v) const { return points[v]; }
    PlanePoint from(int32_t h) const { return points[origin(h)]; }
    PlanePoint to(int32_t h) const { return points[target(h)]; }
    int32_t twin(int32_t h) const { return twins[h]; }
    int32_t edge(int32_t h) const { return std::max(h, twins[h]); }  // one name for both sides

    // A half-edge that leaves v: on the boundary, the boundary one.
    int32_t leaving(int32_t v) const { return out[v]; }
    bool on_boundary(int32_t v) const { return twins[out[v]] < 0; }

    // What a half-edge is called in the input.
    int32_t half_edge_name(int32_t h) const { return 3 * face_name[h / 3] + h % 3; }

    // Calls visit(h) for the half-edges that leave v, counter-clockwise, until it returns true.
    template <class Visit>
    void around(int32_t v, Visit visit) const {
        const int32_t first = out[v];
        for (int32_t h = first;;) {
            if (visit(h)) return;
            h = twins[prev(h)];
            if (h < 0 || h == first) return;
        }
    }

  private:
    Array<PlanePoint> points;
    Array<int32_t> faces, twins, out;

    // Along a Z-order curve over a grid with about as many cells as there are faces.
    void sort_faces(const Triangulation& t) {
        PlanePoint low = t.points[0], high = low;
        for (int64_t v = 0; v < vertex_count; ++v) {
            low = {std::min(low.x, t.points[v].x), std::min(low.y, t.points[v].y)};
            high = {std::max(high.x, t.points[v].x), std::max(high.y, t.points[v].y)};
        }
        int bits = 1;
        while (bits < 12 && (int64_t(1) << (2 * bits)) < face_count) ++bits;
        const double width = double(std::max({high.x - low.x, high.y - low.y, int64_t(1)}));
        const double scale = double((1 << bits) - 1) / width;
        Array<int32_t> cell(face_count), start((size_t(1) << (2 * bits)) + 1, 0);
        for (int64_t f = 0; f < face_count; ++f) {
            const PlanePoint p = t.points[t.faces[3 * f]];
            cell[f] = spread(int32_t(double(p.x - low.x) * scale)) |
                      spread(int32_t(double(p.y - low.y) * scale)) << 1;
            ++start[cell[f] + 1];
        }
        for (size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
        face_name.resize(face_count);
        for (int64_t f = 0; f < face_count; ++f) face_name[start[cell[f]]++] = int32_t(f);
    }

    static int32_t spread(int32_t bits) {  // bit i to bit 2 i
        bits = (bits | bits << 8) & 0x00ff00ff;
        bits = (bits | bits << 4) & 0x0f0f0f0f;
        bits = (bits | bits << 2) & 0x33333333;
        return (bits | bits << 1) & 0x55555555;
    }

    void number_vertices(const Triangulation& t) {
        vertex_number.assign(vertex_count, -1);
        vertex_name.reserve(vertex_count);
        points.reserve(vertex_count);
        faces.reserve(3 * face_count);
        for (const int32_t f : face_name)
            for (int i = 0; i < 3; ++i) {
                const int32_t v = t.faces[3 * f + i];
                if (vertex_number[v] < 0) {
                    vertex_number[v] = int32_t(vertex_name.size());
                    vertex_name.push_back(v);
                    points.push_back(t.points[v]);
                }
                faces.push_back(vertex_number[v]);
            }
    }

    void link(const Triangulation& t) {
        Array<int32_t> number(face_count);
        for (int64_t f = 0; f < face_count; ++f) number[face_name[f]] = int32_t(f);
        twins.reserve(3 * face_count);
        for (const int32_t f : face_name)
            for (int i = 0; i < 3; ++i) {
                const int32_t twin = t.twins[3 * f + i];
                twins.push_back(twin < 0 ? -1 : 3 * number[twin / 3] + twin % 3);
            }
        out.assign(vertex_count, -1);
        for (int32_t h = 0; h < 3 * face_count; ++h)
            if (out[faces[h]] < 0 || twins[h] < 0) out[faces[h]] = h;
    }
};

}  // namespace henkei
