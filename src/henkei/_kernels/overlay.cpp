// The overlay (common subdivision) of two triangulations of one polygon.
//
// T. Kanai, H. Suzuki, F. Kimura: A method of combining two arbitrary triangular meshes
// homeomorphic to a disk (1999), Section 4. Edges of each mesh are walked through the faces of the
// other (4.1, Fig. 3), starting from the boundary, which both share; so crossings come sorted along
// the edges of both meshes (4.2, Fig. 6). Edge cycles around the nodes (4.3, Fig. 8) give the faces
// (4.4, Fig. 9).
//
// Only the left-side test (eq. 6) decides, on integers, exactly. Where the paper breaks ties by
// symbolic perturbation (4.6), a tie is here what it is: an edge may pass through a vertex of the
// other mesh or run along one of its edges. So coincident vertices and edges are one from the
// start, no face without area exists, and the result does not depend on the order of the vertices.
//
// Every face is the intersection of two triangles, and its corners are strictly convex: a vertex
// within another mesh's edge has an edge of its own on either side. Any fan triangulates it.
#include "overlay.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "barycentric.hpp"
#include "walk.hpp"

namespace henkei {
namespace {

// The subdivision itself. Edge e is two half-edges, 2 e and 2 e + 1; h ^ 1 is the twin of h.
class Subdivision {
  public:
    Subdivision(const SortedMesh& a, const SortedMesh& b, const Trace& ta, const Trace& tb,
                const Array<int32_t>& boundary, int shift)
        : a(a),
          b(b),
          ta(ta),
          tb(tb),
          boundary(boundary.data()),
          boundary_count(int64_t(boundary.size() / 2)),
          shift(shift) {}

    OverlayResult run() {
        number_nodes();
        split_boundary();
        split_edges_of_a();
        split_edges_of_b();
        link_cycles();
        place_nodes();
        walk_faces();
        name_edges();
        return std::move(result);
    }

  private:
    const SortedMesh &a, &b;
    const Trace &ta, &tb;
    const int32_t* boundary;
    const int64_t boundary_count;
    const int shift;
    OverlayResult result;

    int64_t node_count = 0, first_crossing = 0;

    // Half-edges 2 e and 2 e + 1. `in_a`: the face of a in which the edge lies, or ~half-edge of a
    // that it is part of, in the direction of 2 e; `in_b` likewise.
    struct Edge {
        int32_t head[2];      // node at which each half-edge ends
        int32_t follower[2];  // next half-edge of its face, -1 outside
        int32_t in_a, in_b;
    };
    Array<Edge> edges;

    int32_t head(int32_t h) const { return edges[h / 2].head[h % 2]; }
    int32_t& follower(int32_t h) { return edges[h / 2].follower[h % 2]; }

    // Face of a mesh on the left of a half-edge of the subdivision.
    static int32_t left_face(const SortedMesh& mesh, int32_t inside, int32_t h) {
        if (inside >= 0) return inside;
        return (h % 2 == 0 ? ~inside : mesh.twin(~inside)) / 3;
    }

    // The half-edges that leave each vertex along each inner half-edge of a and of b.
    Array<int32_t> leaving_a, leaving_b;
    // Where an edge of the other mesh passes through a node: half-edges in and out.
    Array<std::array<int32_t, 2>> passing;
    // Around a crossing, counter-clockwise: a forward, b to a's left, a backward, b to a's right.
    Array<std::array<int32_t, 4>> cycles;

    // Where an edge of a crosses an edge of b, or runs along it; listed per edge of b.
    struct Meeting {
        int32_t edge_of_b, edge_of_a, item;  // item: the crossing's number, or the common edge
    };

    Array<int32_t> node_of_b;
    int32_t node_of_a(int32_t v) const { return a.vertex_name[v]; }

    int32_t add_edge(int32_t from, int32_t to, int32_t in_a, int32_t in_b) {
        edges.push_back({{to, from}, {-1, -1}, in_a, in_b});
        return int32_t(2 * edges.size() - 2);
    }

    void number_nodes() {
        node_count = a.vertex_count;
        node_of_b.resize(b.vertex_count);
        result.node_of_b.resize(b.vertex_count);
        for (int32_t name = 0; name < b.vertex_count; ++name) {
            const int32_t w = b.vertex_number[name];
            const Place place = tb.places[w];
            if (place.kind == Place::kUnknown)
                throw std::logic_error("overlay: a vertex not reached");
            node_of_b[w] =
                place.kind == Place::kVertex ? node_of_a(place.id) : int32_t(node_count++);
            result.node_of_b[name] = node_of_b[w];
        }
        first_crossing = node_count;
        const auto crossed = [](int32_t hit) { return hit >= 0; };
        result.crossings = std::count_if(ta.hits.begin(), ta.hits.end(), crossed);
        if (result.crossings != std::count_if(tb.hits.begin(), tb.hits.end(), crossed))
            throw std::logic_error("overlay: the two walks disagree");
        node_count += result.crossings;
        if (ta.lanes.size() + tb.lanes.size() + boundary_count > (size_t(1) << 30) - 1)
            throw std::length_error("overlay: more than 2^30 edges");
        passing.assign(first_crossing, {-1, -1});
        cycles.resize(result.crossings);
        leaving_a.assign(3 * a.face_count, -1);
        leaving_b.assign(3 * b.face_count, -1);
        edges.reserve(boundary_count + ta.lanes.size() + tb.lanes.size());
        meetings.reserve(result.crossings);
    }

    int32_t boundary_node(int64_t i) const {
        const int32_t* pair = boundary + 2 * (i % boundary_count);
        return pair[0] >= 0 ? node_of_a(pair[0]) : node_of_b[pair[1]];
    }

    // Edge i runs from boundary node i to the next one.
    void split_boundary() {
        int32_t of_a = -1, of_b = -1;
        for (int64_t i = 0; i < 2 * boundary_count; ++i) {
            const int32_t* pair = boundary + 2 * (i % boundary_count);
            if (pair[0] >= 0) of_a = a.leaving(pair[0]);
            if (pair[1] >= 0) of_b = b.leaving(pair[1]);
            if (i >= boundary_count) add_edge(boundary_node(i), boundary_node(i + 1), ~of_a, ~of_b);
        }
    }

    Array<Meeting> meetings;
    Array<int64_t> meetings_of;  // meetings of each edge of b: from [edge] to [edge + 1]

    void split_edges_of_a() {
        int32_t crossings = 0;
        for (size_t k = 0; k < ta.walked.size(); ++k) {
            if (k % kCheckEvery == 0) check_interrupt();
            const int32_t h = ta.walked[k];
            int32_t node = node_of_a(a.origin(h)), last = -1;
            for (int64_t i = ta.start[k]; i <= ta.start[k + 1]; ++i) {
                const bool final = i == ta.start[k + 1];
                const int32_t lane = ta.lanes[i + k], hit = final ? ~0 : ta.hits[i];
                const int32_t to = final      ? node_of_a(a.target(h))
                                   : hit >= 0 ? int32_t(first_crossing) + crossings
                                              : node_of_b[~hit];
                const int32_t edge = add_edge(node, to, ~h, lane);
                if (lane < 0) meetings.push_back({b.edge(~lane), h, edge});
                if (last < 0)
                    leaving_a[h] = edge;
                else
                    join(node, last, edge);
                if (hit >= 0 && !final) {
                    meetings.push_back({b.edge(hit), h, crossings});
                    ++crossings;
                }
                node = to;
                last = edge;
            }
            leaving_a[a.twin(h)] = last ^ 1;
        }
        list_meetings();
    }

    // Half-edge `in` of a ends at a node within an edge, where `out` begins.
    void join(int32_t node, int32_t in, int32_t out) {
        if (node >= first_crossing) {
            cycles[node - first_crossing][0] = out;
            cycles[node - first_crossing][2] = in ^ 1;
        } else {
            passing[node] = {in, out};
        }
    }

    void list_meetings() {  // counting sort by edge of b
        meetings_of.assign(3 * b.face_count + 1, 0);
        for (const Meeting& m : meetings) ++meetings_of[m.edge_of_b + 1];
        for (size_t e = 1; e < meetings_of.size(); ++e) meetings_of[e] += meetings_of[e - 1];
        Array<int64_t> fill(meetings_of.begin(), meetings_of.end() - 1);
        Array<Meeting> sorted(meetings.size());
        for (const Meeting& m : meetings) sorted[fill[m.edge_of_b]++] = m;
        meetings = std::move(sorted);
    }

    void split_edges_of_b() {
        Array<Meeting> slot(3 * a.face_count);  // meetings of the present edge, by edge of a
        for (size_t k = 0; k < tb.walked.size(); ++k) {
            if (k % kCheckEvery == 0) check_interrupt();
            const int32_t g = tb.walked[k];
            const int32_t name = b.edge(g);
            for (int64_t m = meetings_of[name]; m < meetings_of[name + 1]; ++m)
                slot[a.edge(meetings[m].edge_of_a)] = meetings[m];
            const auto met = [&](int32_t h) -> const Meeting& {
                const Meeting& m = slot[a.edge(h)];
                if (m.edge_of_b != name) throw std::logic_error("overlay: the two walks disagree");
                return m;
            };
            int32_t node = node_of_b[b.origin(g)], last = -1;
            bool to_left = false;  // whether b passes the crossing before this lane to a's left
            for (int64_t i = tb.start[k]; i <= tb.start[k + 1]; ++i) {
                const bool final = i == tb.start[k + 1];
                const int32_t lane = tb.lanes[i + k], hit = final ? ~0 : tb.hits[i];
                const int32_t to = final      ? node_of_b[b.target(g)]
                                   : hit >= 0 ? int32_t(first_crossing) + met(hit).item
                                              : node_of_a(~hit);
                int32_t edge;
                if (lane < 0) {
                    const Meeting& common = met(~lane);
                    edge = common.edge_of_a == ~lane ? common.item : common.item ^ 1;
                } else {
                    edge = add_edge(node, to, lane, ~g);
                }
                if (last < 0)
                    leaving_b[g] = edge;
                else if (node < first_crossing)
                    passing[node] = {last, edge};
                else {
                    cycles[node - first_crossing][to_left ? 1 : 3] = edge;
                    cycles[node - first_crossing][to_left ? 3 : 1] = last ^ 1;
                }
                if (hit >= 0 && !final) to_left = met(hit).edge_of_a != hit;
                node = to;
                last = edge;
            }
            leaving_b[b.twin(g)] = last ^ 1;
        }
    }

    // A half-edge that leaves a node, and a point in its direction.
    struct Spoke {
        int32_t half_edge;
        PlanePoint towards;
    };
    Array<Spoke> spokes;

    // `spokes` lie counter-clockwise around their node: link the faces between them.
    void link(bool closed) {
        const size_t count = spokes.size();
        for (size_t i = 0; i + (closed ? 0 : 1) < count; ++i)
            follower(spokes[(i + 1) % count].half_edge ^ 1) = spokes[i].half_edge;
    }

    void gather(const SortedMesh& mesh, int32_t vertex, const Array<int32_t>& leaving) {
        mesh.around(vertex, [&](int32_t h) {
            if (mesh.twin(h) >= 0) spokes.push_back({leaving[h], mesh.to(h)});
            return false;
        });
    }

    // Sorts the spokes counter-clockwise, starting with the first; a common edge is one spoke.
    void sort_spokes(PlanePoint centre) {
        const PlanePoint start = spokes[0].towards;
        const auto turn = [&](PlanePoint p) {
            const int side = left(centre, start, p);
            if (side == 0) return same_side(centre, start, p) ? 0 : 2;
            return side > 0 ? 1 : 3;
        };
        std::sort(spokes.begin(), spokes.end(), [&](const Spoke& p, const Spoke& q) {
            const int u = turn(p.towards), v = turn(q.towards);
            return u != v ? u < v : left(centre, p.towards, q.towards) > 0;
        });
        const auto same = [](const Spoke& p, const Spoke& q) { return p.half_edge == q.half_edge; };
        spokes.erase(std::unique(spokes.begin(), spokes.end(), same), spokes.end());
    }

    void link_cycles() {
        link_boundary_nodes();
        link_vertices(a, ta.places, leaving_a, b, leaving_b, true);
        link_vertices(b, tb.places, leaving_b, a, leaving_a, false);
        for (const auto& cycle : cycles)
            for (int i = 0; i < 4; ++i) follower(cycle[(i + 1) % 4] ^ 1) = cycle[i];
    }

    void link_vertices(const SortedMesh& own, const Array<Place>& places,
                       const Array<int32_t>& leaving, const SortedMesh& other,
                       const Array<int32_t>& leaving_other, bool with_shared) {
        for (int32_t v = 0; v < own.vertex_count; ++v) {
            if (v % kCheckEvery == 0) check_interrupt();
            const Place place = places[v];
            if (own.on_boundary(v) || (place.kind == Place::kVertex && !with_shared)) continue;
            spokes.clear();
            gather(own, v, leaving);
            if (place.kind == Place::kVertex) gather(other, place.id, leaving_other);
            if (place.kind == Place::kEdge) {
                const int32_t node = with_shared ? node_of_a(v) : node_of_b[v];
                const int32_t along =
                    edge_under(passing[node][1], with_shared ? b : a, with_shared);
                spokes.push_back({passing[node][1], other.to(along)});
                spokes.push_back({passing[node][0] ^ 1, other.from(along)});
            }
            if (place.kind != Place::kFace) sort_spokes(own.point(v));
            link(true);
        }
    }

    // The half-edge of a mesh along which a half-edge of the subdivision runs.
    int32_t edge_under(int32_t h, const SortedMesh& mesh, bool mesh_is_b) const {
        const int32_t along = ~(mesh_is_b ? edges[h / 2].in_b : edges[h / 2].in_a);
        return h % 2 == 0 ? along : mesh.twin(along);
    }

    void link_boundary_nodes() {
        for (int64_t i = 0; i < boundary_count; ++i) {
            const int32_t* pair = boundary + 2 * i;
            const int64_t before = (i + boundary_count - 1) % boundary_count;
            spokes.clear();
            spokes.push_back({int32_t(2 * i), boundary_point(i + 1)});
            if (pair[0] >= 0) gather(a, pair[0], leaving_a);
            if (pair[1] >= 0) gather(b, pair[1], leaving_b);
            spokes.push_back({int32_t(2 * before + 1), boundary_point(before)});
            sort_spokes(boundary_point(i));
            link(false);
        }
    }

    PlanePoint boundary_point(int64_t i) const {
        const int32_t* pair = boundary + 2 * (i % boundary_count);
        return pair[0] >= 0 ? a.point(pair[0]) : b.point(pair[1]);
    }

    void place_nodes() {
        result.on_face_a.resize(node_count);
        result.on_face_b.resize(node_count);
        result.bary_a.resize(3 * node_count);
        result.bary_b.resize(3 * node_count);
        result.plane.resize(2 * node_count);
        const int64_t unit = int64_t(1) << shift;
        const auto place = [&](int64_t n, Place in_a, Place in_b, PlanePoint p) {
            weigh(a, in_a, p, &result.on_face_a[n], &result.bary_a[3 * n]);
            weigh(b, in_b, p, &result.on_face_b[n], &result.bary_b[3 * n]);
            result.plane[2 * n] = p.x * unit;
            result.plane[2 * n + 1] = p.y * unit;
        };
        for (int32_t w = 0; w < b.vertex_count; ++w)
            place(node_of_b[w], tb.places[w], {Place::kVertex, w}, b.point(w));
        for (int32_t v = 0; v < a.vertex_count; ++v)
            place(node_of_a(v), {Place::kVertex, v}, ta.places[v], a.point(v));
        for (int64_t c = 0; c < result.crossings; ++c) place_crossing(c);
    }

    void place_crossing(int64_t c) {
        const int64_t n = first_crossing + c;
        const int32_t h = ~edges[cycles[c][0] / 2].in_a, g = ~edges[cycles[c][1] / 2].in_b;
        const PlanePoint p = a.from(h), q = a.to(h), r = b.from(g), s = b.to(g);
        const Wide p_side = area(r, s, p), q_side = area(r, s, q);
        const Wide r_side = area(p, q, r), s_side = area(p, q, s);
        const long double along_a = (long double)p_side / (long double)(p_side - q_side);
        const long double along_b = (long double)r_side / (long double)(r_side - s_side);
        weigh_edge(a, h, double(along_a), &result.on_face_a[n], &result.bary_a[3 * n]);
        weigh_edge(b, g, double(along_b), &result.on_face_b[n], &result.bary_b[3 * n]);
        const int64_t unit = int64_t(1) << shift;
        result.plane[2 * n] = p.x * unit + std::llround(along_a * unit * (q.x - p.x));
        result.plane[2 * n + 1] = p.y * unit + std::llround(along_a * unit * (q.y - p.y));
    }

    PlanePoint rounded(int32_t node) const {
        return {result.plane[2 * node], result.plane[2 * node + 1]};
    }

    void walk_faces() {
        // Triangles by Euler's formula: V - E + F = 1 and 3 F = 2 E - boundary.
        const size_t triangles = 2 * node_count - 2 - boundary_count;
        result.faces.reserve(3 * triangles);
        result.face_a.reserve(triangles);
        result.face_b.reserve(triangles);
        result.edges.reserve(2 * (node_count + triangles - 1));
        for (const Edge& edge : edges)
            for (const int32_t node : {edge.head[1], edge.head[0]}) result.edges.push_back(node);
        for (int32_t first = 0; first < int32_t(2 * edges.size()); ++first) {
            if (first % kCheckEvery == 0) check_interrupt();
            if (follower(first) >= 0) walk_face(first);
        }
        if (result.face_a.size() != triangles) throw std::logic_error("overlay: faces are missing");
    }

    // Half-edges are marked as walked by taking their follower away.
    void walk_face(int32_t first) {
        const int32_t of_a = left_face(a, edges[first / 2].in_a, first);
        const int32_t of_b = left_face(b, edges[first / 2].in_b, first);
        int32_t corners[6];
        int count = 0;
        for (int32_t h = first; follower(h) >= 0; ++count) {
            if (count == 6) throw std::logic_error("overlay: a face does not close");
            corners[count] = head(h);
            h = std::exchange(follower(h), -1);
        }
        if (count < 3) throw std::logic_error("overlay: a face with two corners");
        const int best = count > 3 ? fan_apex(corners, count) : 0;
        for (int i = 1; i + 1 < count; ++i) {
            const int32_t second = corners[(best + i) % count],
                          third = corners[(best + i + 1) % count];
            for (const int32_t corner : {corners[best], second, third})
                result.faces.push_back(corner);
            result.face_a.push_back(a.face_name[of_a]);
            result.face_b.push_back(b.face_name[of_b]);
            if (i == 1) continue;
            result.edges.push_back(corners[best]);
            result.edges.push_back(second);
        }
    }

    // The corner whose fan has the largest smallest triangle.
    int fan_apex(const int32_t* corners, int count) const {
        int best = 0;
        Wide best_area = 0;
        for (int apex = 0; apex < (count == 4 ? 2 : count); ++apex) {
            Wide smallest = 0;
            for (int i = 1; i + 1 < count; ++i) {
                const Wide size = area(rounded(corners[apex]), rounded(corners[(apex + i) % count]),
                                       rounded(corners[(apex + i + 1) % count]));
                if (i == 1 || size < smallest) smallest = size;
            }
            if (apex == 0 || smallest > best_area) best = apex, best_area = smallest;
        }
        return best;
    }

    // Diagonals come after the parts of original edges.
    void name_edges() {
        result.edge_a.assign(result.edges.size() / 2, -1);
        result.edge_b.assign(result.edges.size() / 2, -1);
        for (size_t e = 0; e < edges.size(); ++e) {
            if (edges[e].in_a < 0) result.edge_a[e] = a.half_edge_name(~edges[e].in_a);
            if (edges[e].in_b < 0) result.edge_b[e] = b.half_edge_name(~edges[e].in_b);
        }
    }
};

}  // namespace

OverlayResult overlay(const Triangulation& a, const Triangulation& b, const int32_t* boundary,
                      int64_t boundary_count, int shift) {
    const SortedMesh mesh_a(a), mesh_b(b);
    Array<int32_t> nodes(2 * boundary_count);
    for (int64_t i = 0; i < 2 * boundary_count; ++i) {
        const SortedMesh& mesh = i % 2 == 0 ? mesh_a : mesh_b;
        nodes[i] = boundary[i] < 0 ? -1 : mesh.vertex_number[boundary[i]];
    }
    const Trace through_b = Walk(mesh_a, mesh_b, nodes, 0).run();
    const Trace through_a = Walk(mesh_b, mesh_a, nodes, 1).run();
    return Subdivision(mesh_a, mesh_b, through_b, through_a, nodes, shift).run();
}

Array<int32_t> not_positive(const PlanePoint* points, const int32_t* triangles, int64_t count) {
    Array<int32_t> bad;
    for (int64_t f = 0; f < count; ++f) {
        const int32_t* t = triangles + 3 * f;
        if (left(points[t[0]], points[t[1]], points[t[2]]) <= 0) bad.push_back(int32_t(f));
    }
    return bad;
}

}  // namespace henkei
