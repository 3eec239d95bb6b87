// Edges of one triangulation walked through the faces of another (4.1, Fig. 3 of the paper that
// overlay.cpp names).
#pragma once

#include <stdexcept>
#include <utility>

#include "kernels.hpp"
#include "triangulation.hpp"

namespace henkei {

constexpr int kCheckEvery = 1 << 14;

// A place on a triangulation: on a vertex, within an edge (a half-edge) or within a face.
struct Place {
    enum Kind : int8_t { kUnknown, kVertex, kEdge, kFace } kind = kUnknown;
    int32_t id = -1;
};

// The inner edges of one mesh as they run through the other.
struct Trace {
    Array<int32_t> walked;  // the half-edge of each edge along which it was walked
    Array<int64_t> start;   // its hits are start[k] to start[k + 1]; it has one lane more
    Array<int32_t> hits;    // half-edge crossed from its left to its right, or ~vertex passed
    Array<int32_t> lanes;   // face between two hits, or ~half-edge along which the edge runs
    Array<Place> places;    // of the mesh's vertices on the other mesh

    int64_t first_lane(int64_t k) const { return start[k] + k; }
};

// Walks all inner edges of `own` through `other` (4.1, Fig. 3).
class Walk {
  public:
    // `boundary`: pairs of a vertex of the first and of the second mesh, or -1; see overlay.hpp.
    Walk(const SortedMesh& own, const SortedMesh& other, const Array<int32_t>& boundary, int column)
        : own(own), other(other) {
        const size_t edges = own.face_count + (own.face_count + 1) / 2;
        trace.walked.reserve(edges);
        trace.start.reserve(edges + 1);
        trace.hits.reserve(4 * own.face_count);  // touched only as it fills
        trace.lanes.reserve(6 * own.face_count);
        place_boundary(boundary, column);
    }

    Trace run() {
        Array<int32_t> stack;
        Array<char> done(3 * own.face_count, 0);
        for (int32_t v = 0; v < own.vertex_count; ++v)
            if (trace.places[v].kind != Place::kUnknown) stack.push_back(v);
        for (int64_t count = 0; !stack.empty(); ++count) {
            if (count % kCheckEvery == 0) check_interrupt();
            const int32_t v = stack.back();
            stack.pop_back();
            own.around(v, [&](int32_t h) {
                const int32_t back = own.twin(h);
                if (back < 0 || done[h] || done[back]) return false;
                done[h] = 1;
                Place& end = trace.places[own.target(h)];
                if (end.kind == Place::kUnknown) stack.push_back(own.target(h));
                trace.walked.push_back(h);
                trace.start.push_back(int64_t(trace.hits.size()));
                end = along(h);
                return false;
            });
        }
        trace.start.push_back(int64_t(trace.hits.size()));
        return std::move(trace);
    }

  private:
    const SortedMesh &own, &other;
    Trace trace;
    PlanePoint a, b;  // the ends of the edge being walked
    Place goal;       // the place of b where it is known beforehand
    Place at;         // where the walk is; kUnknown once it has ended in `reached`
    Place reached;
    int32_t entered;  // in a face: the half-edge of it on which the walk lies, or -1

    void place_boundary(const Array<int32_t>& boundary, int column) {
        trace.places.resize(own.vertex_count);
        int32_t edge = -1;  // the other mesh's boundary half-edge that holds the nodes to come
        for (size_t i = 0; i < 2 * boundary.size(); i += 2) {  // twice around
            const int32_t* node = boundary.data() + i % boundary.size();
            const int32_t mine = node[column], theirs = node[1 - column];
            if (theirs >= 0) edge = other.leaving(theirs);
            if (mine < 0) continue;
            trace.places[mine] =
                theirs >= 0 ? Place{Place::kVertex, theirs} : Place{Place::kEdge, edge};
        }
    }

    Place along(int32_t h) {
        a = own.from(h);
        b = own.to(h);
        goal = trace.places[own.target(h)];
        at = trace.places[own.origin(h)];
        entered = -1;
        for (int64_t steps = 0; at.kind != Place::kUnknown; ++steps) {
            if (steps > 2 * other.face_count + 2)
                throw std::logic_error("overlay: an edge does not end");
            if (at.kind == Place::kVertex)
                leave_vertex(at.id);
            else if (at.kind == Place::kEdge)
                leave_edge(at.id);
            else
                cross_face(at.id);
        }
        return reached;
    }

    void end(Place::Kind kind, int32_t id) {
        reached = {kind, id};
        at = {};
    }

    // From a vertex of the other mesh: along one of its edges, or into the face towards b. Nothing
    // lies beyond a boundary edge, whatever its rounded ends would tell.
    void leave_vertex(int32_t v) {
        bool found = false;
        other.around(v, [&](int32_t h) {
            const int32_t last = prev(h);  // the other half-edge of the face at v
            const int side = other.twin(h) < 0 ? 1 : left(other.from(h), other.to(h), b);
            if (side == 0 && same_side(other.from(h), other.to(h), b)) {
                follow(h);
                return found = true;
            }
            if (side > 0 &&
                (other.twin(last) < 0 || left(other.from(h), other.from(last), b) < 0)) {
                trace.lanes.push_back(h / 3);
                if (!ends_on_boundary_of(h / 3)) leave_through(next(h), false);
                return found = true;
            }
            return false;
        });
        if (!found)
            throw std::logic_error("overlay: an edge leaves the common polygon at a vertex");
    }

    // From a point within an edge of the other mesh, on which the edge being walked starts.
    void leave_edge(int32_t h) {
        const int32_t back = other.twin(h);
        const int side = back < 0 ? 1 : left(other.from(h), other.to(h), b);
        if (side == 0) return follow(same_side(a, other.to(h), b) ? h : back);
        entered = side > 0 ? h : back;
        at = {Place::kFace, entered / 3};
    }

    // Through a face of the other mesh, from `entered` or from a point inside.
    void cross_face(int32_t face) {
        trace.lanes.push_back(face);
        if (ends_on_boundary_of(face)) return;
        int32_t exit = -1;
        int side = 0;
        if (entered >= 0) {  // its origin lies left of the edge, its target right
            const int32_t apex = prev(entered);
            side = left(a, b, other.from(apex));
            exit = side > 0 ? next(entered) : apex;
            if (side > 0) side = -1;  // then the exit's origin is the entered edge's target
        } else {
            int sides[3];
            for (int i = 0; i < 3; ++i) sides[i] = left(a, b, other.from(3 * face + i));
            for (int i = 0; i < 3; ++i)
                if (sides[i] <= 0 && sides[(i + 1) % 3] > 0) exit = 3 * face + i, side = sides[i];
            if (exit < 0) throw std::logic_error("overlay: an edge without extent");
        }
        leave_through(exit, side == 0);
    }

    // Out of a face through `exit`, or exactly through its origin; unless b comes before.
    void leave_through(int32_t exit, bool through_origin) {
        const int side = left(other.from(exit), other.to(exit), b);
        if (side > 0 || (other.twin(exit) < 0 && !through_origin))
            return end(Place::kFace, exit / 3);
        if (through_origin) return side == 0 ? end(Place::kVertex, other.origin(exit)) : pass(exit);
        if (side == 0) return end(Place::kEdge, exit);
        trace.hits.push_back(exit);
        entered = other.twin(exit);
        at = {Place::kFace, entered / 3};
    }

    // Along an edge of the other mesh.
    void follow(int32_t h) {
        trace.lanes.push_back(~h);
        const int order = between(other.from(h), b, other.to(h));
        if (order > 0) return end(Place::kEdge, h);
        if (order == 0) return end(Place::kVertex, other.target(h));
        pass(next(h));
    }

    // Through the vertex at which half-edge h starts.
    void pass(int32_t h) {
        trace.hits.push_back(~other.origin(h));
        at = {Place::kVertex, other.origin(h)};
    }

    // An edge that ends within a boundary edge of this face ends here: points on the boundary are
    // rounded, so that no left-side test could tell.
    bool ends_on_boundary_of(int32_t face) {
        const bool ends =
            goal.kind == Place::kEdge && other.twin(goal.id) < 0 && goal.id / 3 == face;
        if (ends) end(goal.kind, goal.id);
        return ends;
    }
};

}  // namespace henkei
