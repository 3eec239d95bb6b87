// The overlay (common subdivision) of two triangulations of one polygon.
//
// T. Kanai, H. Suzuki, F. Kimura: A method of combining two arbitrary triangular meshes homeomorphic
// to a disk (1999), Section 4. Edges of each mesh are walked through the faces of the other (4.1,
// Fig. 3), starting from the boundary, which both share; so crossings come sorted along the edges of
// both meshes (4.2, Fig. 6). Edge cycles around the nodes (4.3, Fig. 8) give the faces (4.4, Fig. 9).
//
// Only the left-side test (eq. 6) decides, on integers, exactly. Where the paper breaks ties by
// symbolic perturbation (4.6), a tie is here what it is: an edge may pass through a vertex of the
// other mesh or run along one of its edges. So coincident vertices and edges are one from the start,
// no face without area exists, and the result does not depend on the order of the vertices.
//
// Every face is the intersection of two triangles, and its corners are strictly convex: a vertex
// within another mesh's edge has an edge of its own on either side. Any fan triangulates it.
#include "overlay.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "kernels.hpp"

namespace henkei {
namespace {

constexpr int kCheckEvery = 1 << 14;

int32_t next(int32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
int32_t prev(int32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

// A triangulation with one outgoing half-edge per vertex: on the boundary, the boundary one.
struct Mesh : Triangulation {
    std::vector<int32_t> out;

    explicit Mesh(const Triangulation& t) : Triangulation(t), out(t.vertex_count, -1) {
        for (int32_t h = 0; h < 3 * face_count; ++h)
            if (out[faces[h]] < 0 || twins[h] < 0) out[faces[h]] = h;
    }
    int32_t origin(int32_t h) const { return faces[h]; }
    int32_t target(int32_t h) const { return faces[next(h)]; }
    PlanePoint from(int32_t h) const { return points[origin(h)]; }
    PlanePoint to(int32_t h) const { return points[target(h)]; }
    bool on_boundary(int32_t v) const { return twins[out[v]] < 0; }
    int32_t edge(int32_t h) const { return std::max(h, twins[h]); }  // one name for both sides

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
};

// The inner edges of one mesh as they run through the other.
struct Trace {
    std::vector<int32_t> walked;  // the half-edge of each edge along which it was walked
    std::vector<int64_t> start;   // its hits are start[k] to start[k + 1]; it has one lane more
    std::vector<int32_t> hits;    // half-edge crossed from its left to its right, or ~vertex passed
    std::vector<int32_t> lanes;   // face between two hits, or ~half-edge along which the edge runs
    std::vector<Place> places;    // of the mesh's vertices on the other mesh

    int64_t first_lane(int64_t k) const { return start[k] + k; }
};

// Walks all inner edges of `own` through `other` (4.1, Fig. 3).
class Walk {
  public:
    Walk(const Mesh& own, const Mesh& other, std::vector<Place> places) : own(own), other(other) {
        trace.places = std::move(places);
    }

    Trace run() {
        std::vector<int32_t> stack;
        std::vector<char> done(3 * own.face_count, 0);
        for (int32_t v = 0; v < own.vertex_count; ++v)
            if (trace.places[v].kind != Place::kUnknown) stack.push_back(v);
        for (int64_t count = 0; !stack.empty(); ++count) {
            if (count % kCheckEvery == 0) check_interrupt();
            const int32_t v = stack.back();
            stack.pop_back();
            own.around(v, [&](int32_t h) {
                const int32_t back = own.twins[h];
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
    const Mesh &own, &other;
    Trace trace;
    PlanePoint a, b;  // the ends of the edge being walked
    Place goal;       // the place of b where it is known beforehand
    Place at;         // where the walk is; kUnknown once it has ended in `reached`
    Place reached;
    int32_t entered;  // in a face: the half-edge of it on which the walk lies, or -1

    Place along(int32_t h) {
        a = own.from(h);
        b = own.to(h);
        goal = trace.places[own.target(h)];
        at = trace.places[own.origin(h)];
        entered = -1;
        while (at.kind != Place::kUnknown) {
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
            const int side = other.twins[h] < 0 ? 1 : left(other.from(h), other.to(h), b);
            if (side == 0 && same_side(other.from(h), other.to(h), b)) {
                follow(h);
                return found = true;
            }
            if (side > 0 &&
                (other.twins[last] < 0 || left(other.from(h), other.from(last), b) < 0)) {
                trace.lanes.push_back(h / 3);
                if (!ends_on_boundary_of(h / 3)) leave_through(next(h), false);
                return found = true;
            }
            return false;
        });
        if (!found) throw std::logic_error("overlay: an edge leaves the common polygon at a vertex");
    }

    // From a point within an edge of the other mesh, on which the edge being walked starts.
    void leave_edge(int32_t h) {
        const int32_t back = other.twins[h];
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
        if (side > 0 || (other.twins[exit] < 0 && !through_origin))
            return end(Place::kFace, exit / 3);
        if (through_origin) return side == 0 ? end(Place::kVertex, other.origin(exit)) : pass(exit);
        if (side == 0) return end(Place::kEdge, exit);
        trace.hits.push_back(exit);
        entered = other.twins[exit];
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
        const bool ends = goal.kind == Place::kEdge && other.twins[goal.id] < 0 && goal.id / 3 == face;
        if (ends) end(goal.kind, goal.id);
        return ends;
    }
};

// Places of the boundary vertices of one mesh on the other, from the common list of nodes.
std::vector<Place> boundary_places(const Mesh& own, const Mesh& other, const int32_t* nodes,
                                   int64_t count, int own_column) {
    std::vector<Place> places(own.vertex_count);
    int32_t edge = -1;  // the other mesh's boundary half-edge that holds the nodes to come
    for (int64_t i = 0; i < 2 * count; ++i) {  // twice around: the first node may be within an edge
        const int32_t* node = nodes + 2 * (i % count);
        const int32_t mine = node[own_column], theirs = node[1 - own_column];
        if (theirs >= 0) edge = other.out[theirs];
        if (mine < 0) continue;
        places[mine] = theirs >= 0 ? Place{Place::kVertex, theirs} : Place{Place::kEdge, edge};
    }
    return places;
}

// The subdivision itself. An edge is two half-edges, 2 e and 2 e + 1; h ^ 1 is the twin of h.
class Subdivision {
  public:
    Subdivision(const Mesh& a, const Mesh& b, const Trace& ta, const Trace& tb,
                const int32_t* boundary, int64_t boundary_count, int shift)
        : a(a), b(b), ta(ta), tb(tb), boundary(boundary), boundary_count(boundary_count),
          shift(shift) {}

    OverlayResult run() {
        number_nodes();
        split_boundary();
        split_edges_of_a();
        split_edges_of_b();
        link_cycles();
        place_nodes();
        walk_faces();
        collect_edges();
        return std::move(result);
    }

  private:
    const Mesh &a, &b;
    const Trace &ta, &tb;
    const int32_t* boundary;
    const int64_t boundary_count;
    const int shift;
    OverlayResult result;

    int64_t node_count = 0, first_crossing = 0;
    std::vector<int32_t> head;             // node at which each half-edge ends
    std::vector<int32_t> follower;         // next half-edge of its face, -1 outside
    std::vector<int32_t> left_a, left_b;   // face of a and of b on the left of each half-edge
    std::vector<int32_t> part_a, part_b;   // per edge: the half-edge of a and of b it is part of

    // The half-edges that leave each vertex along each inner half-edge of a and of b.
    std::vector<int32_t> leaving_a, leaving_b;
    // Where an edge of the other mesh passes through a node: half-edges in and out.
    std::vector<std::array<int32_t, 2>> passing;
    // Around a crossing, counter-clockwise: a forward, b to a's left, a backward, b to a's right.
    std::vector<std::array<int32_t, 4>> cycles;
    std::vector<std::array<int32_t, 2>> crossing;  // half-edges of a and of b that cross there

    // Where an edge of a crosses an edge of b, or runs along it; listed per edge of b.
    struct Meeting {
        int32_t edge_of_b, edge_of_a, item;  // item: the crossing's number, or the common edge
    };

    int32_t tail(int32_t h) const { return head[h ^ 1]; }

    int32_t add_edge(int32_t from, int32_t to, std::array<int32_t, 2> a_sides,
                     std::array<int32_t, 2> b_sides, int32_t of_a, int32_t of_b) {
        const int32_t h = int32_t(head.size());
        head.insert(head.end(), {to, from});
        left_a.insert(left_a.end(), {a_sides[0], a_sides[1]});
        left_b.insert(left_b.end(), {b_sides[0], b_sides[1]});
        part_a.push_back(of_a);
        part_b.push_back(of_b);
        return h;
    }

    static std::array<int32_t, 2> sides(const Mesh& mesh, int32_t h) {
        return {h / 3, mesh.twins[h] < 0 ? -1 : mesh.twins[h] / 3};
    }

    void number_nodes() {
        node_count = a.vertex_count;
        result.node_of_b.resize(b.vertex_count);
        for (int32_t w = 0; w < b.vertex_count; ++w) {
            const Place place = tb.places[w];
            if (place.kind == Place::kUnknown) throw std::logic_error("overlay: a vertex not reached");
            result.node_of_b[w] = place.kind == Place::kVertex ? place.id : int32_t(node_count++);
        }
        first_crossing = node_count;
        const auto crossed = [](int32_t hit) { return hit >= 0; };
        result.crossings = std::count_if(ta.hits.begin(), ta.hits.end(), crossed);
        if (result.crossings != std::count_if(tb.hits.begin(), tb.hits.end(), crossed))
            throw std::logic_error("overlay: the two walks disagree");
        node_count += result.crossings;
        passing.assign(first_crossing, {-1, -1});
        cycles.resize(result.crossings);
        crossing.resize(result.crossings);
        leaving_a.assign(3 * a.face_count, -1);
        leaving_b.assign(3 * b.face_count, -1);
        const size_t edges = boundary_count + ta.lanes.size() + tb.lanes.size();
        head.reserve(2 * edges);
        left_a.reserve(2 * edges);
        left_b.reserve(2 * edges);
        part_a.reserve(edges);
        part_b.reserve(edges);
    }

    int32_t boundary_node(int64_t i) const {
        const int32_t* pair = boundary + 2 * (i % boundary_count);
        return pair[0] >= 0 ? pair[0] : result.node_of_b[pair[1]];
    }

    // Edge i runs from boundary node i to the next one.
    void split_boundary() {
        int32_t of_a = -1, of_b = -1;
        for (int64_t i = 0; i < 2 * boundary_count; ++i) {
            const int32_t* pair = boundary + 2 * (i % boundary_count);
            if (pair[0] >= 0) of_a = a.out[pair[0]];
            if (pair[1] >= 0) of_b = b.out[pair[1]];
            if (i >= boundary_count)
                add_edge(boundary_node(i), boundary_node(i + 1), sides(a, of_a), sides(b, of_b), of_a,
                         of_b);
        }
    }

    std::vector<Meeting> meetings;
    std::vector<int64_t> meetings_of;  // meetings of each edge of b: from [edge] to [edge + 1]

    void split_edges_of_a() {
        int32_t crossings = 0;
        for (size_t k = 0; k < ta.walked.size(); ++k) {
            if (k % kCheckEvery == 0) check_interrupt();
            const int32_t h = ta.walked[k];
            int32_t node = a.origin(h), last = -1;
            for (int64_t i = ta.start[k]; i <= ta.start[k + 1]; ++i) {
                const bool final = i == ta.start[k + 1];
                const int32_t lane = ta.lanes[i + k], hit = final ? ~0 : ta.hits[i];
                const int32_t to = final      ? a.target(h)
                                   : hit >= 0 ? int32_t(first_crossing) + crossings
                                              : result.node_of_b[~hit];
                const int32_t along = lane < 0 ? ~lane : -1;
                const int32_t edge =
                    add_edge(node, to, sides(a, h),
                             lane < 0 ? sides(b, along) : std::array<int32_t, 2>{lane, lane}, h, along);
                if (along >= 0) meetings.push_back({b.edge(along), h, edge});
                if (last < 0) leaving_a[h] = edge;
                else join(node, last, edge);
                if (hit >= 0 && !final) {
                    meetings.push_back({b.edge(hit), h, crossings});
                    crossing[crossings++] = {h, hit};
                }
                node = to;
                last = edge;
            }
            leaving_a[a.twins[h]] = last ^ 1;
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
        std::vector<int64_t> fill(meetings_of.begin(), meetings_of.end() - 1);
        std::vector<Meeting> sorted(meetings.size());
        for (const Meeting& m : meetings) sorted[fill[m.edge_of_b]++] = m;
        meetings = std::move(sorted);
    }

    void split_edges_of_b() {
        std::vector<Meeting> slot(3 * a.face_count);  // meetings of the present edge, by edge of a
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
            int32_t node = result.node_of_b[b.origin(g)], last = -1;
            bool to_left = false;  // whether b passes the crossing before this lane to a's left
            for (int64_t i = tb.start[k]; i <= tb.start[k + 1]; ++i) {
                const bool final = i == tb.start[k + 1];
                const int32_t lane = tb.lanes[i + k], hit = final ? ~0 : tb.hits[i];
                const int32_t to = final      ? result.node_of_b[b.target(g)]
                                   : hit >= 0 ? int32_t(first_crossing) + met(hit).item
                                              : ~hit;
                int32_t edge;
                if (lane < 0) {
                    const Meeting& common = met(~lane);
                    edge = common.edge_of_a == ~lane ? common.item : common.item ^ 1;
                } else {
                    edge = add_edge(node, to, {lane, lane}, sides(b, g), -1, g);
                }
                if (last < 0) leaving_b[g] = edge;
                else if (node < first_crossing) passing[node] = {last, edge};
                else {
                    cycles[node - first_crossing][to_left ? 1 : 3] = edge;
                    cycles[node - first_crossing][to_left ? 3 : 1] = last ^ 1;
                }
                if (hit >= 0 && !final) to_left = met(hit).edge_of_a != hit;
                node = to;
                last = edge;
            }
            leaving_b[b.twins[g]] = last ^ 1;
        }
    }

    // A half-edge that leaves a node, and a point in its direction.
    struct Spoke {
        int32_t half_edge;
        PlanePoint towards;
    };
    std::vector<Spoke> spokes;

    // `spokes` lie counter-clockwise around their node: link the faces between them.
    void link(bool closed) {
        const size_t count = spokes.size();
        for (size_t i = 0; i + (closed ? 0 : 1) < count; ++i)
            follower[spokes[(i + 1) % count].half_edge ^ 1] = spokes[i].half_edge;
    }

    void gather(const Mesh& mesh, int32_t vertex, const std::vector<int32_t>& leaving) {
        mesh.around(vertex, [&](int32_t h) {
            if (mesh.twins[h] >= 0) spokes.push_back({leaving[h], mesh.to(h)});
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
        follower.assign(head.size(), -1);
        link_boundary_nodes();
        link_vertices(a, ta.places, leaving_a, b, leaving_b, true);
        link_vertices(b, tb.places, leaving_b, a, leaving_a, false);
        for (const auto& cycle : cycles)
            for (int i = 0; i < 4; ++i) follower[cycle[(i + 1) % 4] ^ 1] = cycle[i];
    }

    void link_vertices(const Mesh& own, const std::vector<Place>& places,
                       const std::vector<int32_t>& leaving, const Mesh& other,
                       const std::vector<int32_t>& leaving_other, bool with_shared) {
        for (int32_t v = 0; v < own.vertex_count; ++v) {
            if (v % kCheckEvery == 0) check_interrupt();
            const Place place = places[v];
            if (own.on_boundary(v) || (place.kind == Place::kVertex && !with_shared)) continue;
            spokes.clear();
            gather(own, v, leaving);
            if (place.kind == Place::kVertex) gather(other, place.id, leaving_other);
            if (place.kind == Place::kEdge) {
                const int32_t node = with_shared ? v : result.node_of_b[v];
                const int32_t h = passing[node][1], walked = other_part(h, with_shared);
                const bool forward = walked_along(h, walked, with_shared);
                spokes.push_back({h, forward ? other.to(walked) : other.from(walked)});
                spokes.push_back({passing[node][0] ^ 1, forward ? other.from(walked) : other.to(walked)});
            }
            if (place.kind != Place::kFace) sort_spokes(own.points[v]);
            link(true);
        }
    }

    int32_t other_part(int32_t h, bool other_is_b) const {
        return other_is_b ? part_b[h / 2] : part_a[h / 2];
    }

    // Whether half-edge h of the subdivision runs in the direction of the half-edge it is part of.
    bool walked_along(int32_t h, int32_t part, bool of_b) const {
        return (of_b ? left_b : left_a)[h] == part / 3;
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
        return pair[0] >= 0 ? a.points[pair[0]] : b.points[pair[1]];
    }

    // Weights of a place on a mesh (4.5, eq. 7).
    static void weigh(const Mesh& mesh, Place place, PlanePoint p, int32_t* face, double* bary) {
        bary[0] = bary[1] = bary[2] = 0;
        if (place.kind == Place::kVertex) {
            const int32_t h = mesh.out[place.id];
            *face = h / 3;
            bary[h % 3] = 1;
        } else if (place.kind == Place::kEdge) {
            const PlanePoint from = mesh.from(place.id), to = mesh.to(place.id);
            const double along = double(Wide(p.x - from.x) * (to.x - from.x) +
                                        Wide(p.y - from.y) * (to.y - from.y)) /
                                 double(Wide(to.x - from.x) * (to.x - from.x) +
                                        Wide(to.y - from.y) * (to.y - from.y));
            weigh_edge(place.id, along, face, bary);
        } else {
            *face = place.id;
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

    static void weigh_edge(int32_t h, double along, int32_t* face, double* bary) {
        *face = h / 3;
        bary[0] = bary[1] = bary[2] = 0;
        bary[h % 3] = 1 - along;
        bary[next(h) % 3] = along;
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
            place(result.node_of_b[w], tb.places[w], {Place::kVertex, w}, b.points[w]);
        for (int32_t v = 0; v < a.vertex_count; ++v)
            place(v, {Place::kVertex, v}, ta.places[v], a.points[v]);
        for (int64_t c = 0; c < result.crossings; ++c) place_crossing(c);
    }

    void place_crossing(int64_t c) {
        const int64_t n = first_crossing + c;
        const int32_t h = crossing[c][0], g = crossing[c][1];
        const PlanePoint p = a.from(h), q = a.to(h), r = b.from(g), s = b.to(g);
        const Wide p_side = area(r, s, p), q_side = area(r, s, q);
        const Wide r_side = area(p, q, r), s_side = area(p, q, s);
        const long double along_a = (long double)p_side / (long double)(p_side - q_side);
        const long double along_b = (long double)r_side / (long double)(r_side - s_side);
        weigh_edge(h, double(along_a), &result.on_face_a[n], &result.bary_a[3 * n]);
        weigh_edge(g, double(along_b), &result.on_face_b[n], &result.bary_b[3 * n]);
        const int64_t unit = int64_t(1) << shift;
        result.plane[2 * n] = p.x * unit + std::llround(along_a * unit * (q.x - p.x));
        result.plane[2 * n + 1] = p.y * unit + std::llround(along_a * unit * (q.y - p.y));
    }

    PlanePoint rounded(int32_t node) const {
        return {result.plane[2 * node], result.plane[2 * node + 1]};
    }

    void walk_faces() {
        std::vector<char> seen(head.size(), 0);
        std::vector<int32_t> corners;
        result.faces.reserve(3 * head.size() / 2);
        for (int32_t first = 0; first < int32_t(head.size()); ++first) {
            if (first % kCheckEvery == 0) check_interrupt();
            if (seen[first] || follower[first] < 0) continue;
            corners.clear();
            for (int32_t h = first; !seen[h]; h = follower[h]) {
                seen[h] = 1;
                corners.push_back(tail(h));
                if (follower[h] < 0 || corners.size() > 6 || left_a[h] != left_a[first] ||
                    left_b[h] != left_b[first])
                    throw std::logic_error("overlay: a face does not close");
            }
            triangulate(corners, left_a[first], left_b[first]);
        }
    }

    // As a fan whose smallest triangle is as large as can be.
    void triangulate(const std::vector<int32_t>& corners, int32_t of_a, int32_t of_b) {
        const int count = int(corners.size());
        if (count < 3) throw std::logic_error("overlay: a face with two corners");
        int best = 0;
        Wide best_area = 0;
        for (int apex = 0; count > 3 && apex < count; ++apex) {
            Wide smallest = 0;
            for (int i = 1; i + 1 < count; ++i) {
                const Wide size = area(rounded(corners[apex]), rounded(corners[(apex + i) % count]),
                                       rounded(corners[(apex + i + 1) % count]));
                if (i == 1 || size < smallest) smallest = size;
            }
            if (apex == 0 || smallest > best_area) best = apex, best_area = smallest;
        }
        for (int i = 1; i + 1 < count; ++i) {
            const int32_t second = corners[(best + i) % count], third = corners[(best + i + 1) % count];
            result.faces.insert(result.faces.end(), {corners[best], second, third});
            result.face_a.push_back(of_a);
            result.face_b.push_back(of_b);
            if (i > 1) result.edges.insert(result.edges.end(), {corners[best], second});
        }
    }

    // The diagonals have been listed; the parts of original edges come before them.
    void collect_edges() {
        std::vector<int32_t> diagonals = std::move(result.edges);
        result.edges.clear();
        result.edges.reserve(head.size() + diagonals.size());
        for (size_t e = 0; e < part_a.size(); ++e)
            result.edges.insert(result.edges.end(), {head[2 * e + 1], head[2 * e]});
        result.edges.insert(result.edges.end(), diagonals.begin(), diagonals.end());
        result.edge_a = std::move(part_a);
        result.edge_b = std::move(part_b);
        result.edge_a.resize(result.edges.size() / 2, -1);
        result.edge_b.resize(result.edges.size() / 2, -1);
    }
};

}  // namespace

OverlayResult overlay(const Triangulation& a, const Triangulation& b, const int32_t* boundary,
                      int64_t boundary_count, int shift) {
    const Mesh mesh_a(a), mesh_b(b);
    const Trace through_b =
        Walk(mesh_a, mesh_b, boundary_places(mesh_a, mesh_b, boundary, boundary_count, 0)).run();
    const Trace through_a =
        Walk(mesh_b, mesh_a, boundary_places(mesh_b, mesh_a, boundary, boundary_count, 1)).run();
    return Subdivision(mesh_a, mesh_b, through_b, through_a, boundary, boundary_count, shift).run();
}

std::vector<int32_t> not_positive(const PlanePoint* points, const int32_t* triangles,
                                  int64_t count) {
    std::vector<int32_t> bad;
    for (int64_t f = 0; f < count; ++f) {
        const int32_t* t = triangles + 3 * f;
        if (left(points[t[0]], points[t[1]], points[t[2]]) <= 0) bad.push_back(int32_t(f));
    }
    return bad;
}

}  // namespace henkei
