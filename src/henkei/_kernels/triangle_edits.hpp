// A triangle mesh of half-edges that changes by splits, collapses and flips of its edges.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace henkei {

// Part of a feature curve: where its half-edge starts on the curve, and how far it goes along it.
struct Line {
    int32_t curve = -1;  // -1: no feature
    double start = 0, step = 0;

    bool exists() const { return curve >= 0; }
    Line reversed() const { return {curve, start + step, -step}; }
};

// Half-edge 3 f + i runs from corner i of face f to the next. What is gone has corners -1 (a face)
// or leaves by -1 (a vertex). Every change keeps the surface manifold and its topology.
class TriangleEdits {
  public:
    TriangleEdits(const int32_t* faces, const int32_t* twins, int64_t face_count, int64_t vertices);

    int32_t vertex_count() const { return int32_t(leaving_.size()); }
    int32_t face_count() const { return int32_t(corner_.size() / 3); }
    int32_t half_edge_count() const { return int32_t(corner_.size()); }
    bool has_face(int32_t f) const { return corner_[3 * size_t(f)] >= 0; }
    bool has_vertex(int32_t v) const { return leaving_[v] >= 0; }
    bool has_edge(int32_t h) const { return corner_[h] >= 0; }
    // One half-edge of each edge.
    bool is_first(int32_t h) const { return has_edge(h) && (twin_[h] < 0 || h < twin_[h]); }

    static int32_t next(int32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
    static int32_t previous(int32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
    int32_t origin(int32_t h) const { return corner_[h]; }
    int32_t target(int32_t h) const { return corner_[next(h)]; }
    int32_t apex(int32_t h) const { return corner_[previous(h)]; }
    int32_t twin(int32_t h) const { return twin_[h]; }
    const int32_t* corners(int32_t f) const { return &corner_[3 * size_t(f)]; }
    bool on_boundary(int32_t v) const { return twin_[leaving_[v]] < 0; }

    // Half-edges that leave a vertex, counter-clockwise; on a boundary from its first face to its
    // last.
    template <class Visit>
    void around(int32_t v, Visit visit) const {
        int32_t h = leaving_[v];
        do {
            visit(h);
            h = twin_[previous(h)];
        } while (h >= 0 && h != leaving_[v]);
    }
    // Vertices joined to a vertex.
    template <class Visit>
    void neighbours(int32_t v, Visit visit) const {
        around(v, [&](int32_t h) {
            visit(target(h));
            if (twin_[previous(h)] < 0) visit(apex(h));
        });
    }
    // Edges at a vertex as visit(neighbour, half-edge, whether it leaves the vertex).
    template <class Visit>
    void edges_at(int32_t v, Visit visit) const {
        around(v, [&](int32_t h) {
            visit(target(h), h, true);
            const int32_t last = previous(h);
            if (twin_[last] < 0) visit(origin(last), last, false);
        });
    }
    int32_t degree(int32_t v) const { return degree_[v]; }
    bool adjacent(int32_t v, int32_t w) const;

    const Line& line(int32_t h) const { return line_[h]; }
    void set_line(int32_t h, const Line& line);

    // A new vertex on the edge; the half-edge then ends there, and `continuation` goes on from it.
    int32_t split(int32_t h, int32_t& continuation);
    // A new vertex within the face, joined to its corners.
    int32_t split_face(int32_t f);
    // Whether the topology allows it (link condition; Dey, Edelsbrunner, Guha, Nekhayev 1999).
    bool can_collapse(int32_t h) const;
    // Joins the ends of an edge to one; `gone` is the end that vanishes. A feature edge from it to
    // another neighbour must be set anew.
    void collapse(int32_t h, int32_t gone);
    bool can_flip(int32_t h) const;
    void flip(int32_t h);

  private:
    int32_t new_face(int32_t a, int32_t b, int32_t c);
    int32_t new_vertex();
    void pair(int32_t g, int32_t h);
    void move_outer(int32_t from, int32_t to);

    std::vector<int32_t> corner_, twin_, leaving_, degree_;
    std::vector<Line> line_;
};

}  // namespace henkei
