#include <algorithm>
#include <stdexcept>
#include <string>

#include "support/naive_subdivision.h"

namespace plait::naive {
namespace {

[[noreturn]] void refuse_rings(const std::string& what, Index vertex) {
  throw std::invalid_argument("naive mesh: " + what + ": " + std::to_string(vertex));
}

}  // namespace

Rings::Rings(const Mesh& mesh)
    : mesh_(mesh), first_(mesh.points.size() + 1, 0), triangles_(3 * mesh.triangles.size()) {
  for (const Triangle& triangle : mesh.triangles)
    for (const Index vertex : triangle) ++first_.at(vertex + 1);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) first_[v + 1] += first_[v];
  std::vector<Index> next(first_.begin(), first_.end() - 1);
  for (Index t = 0; t < mesh.triangles.size(); ++t)
    for (const Index vertex : mesh.triangles[t]) triangles_[next[vertex]++] = t;
}

void Rings::find(Index vertex, Ring& ring) const {
  // In each triangle (vertex, p, q), q follows p.
  struct Link {
    Index from, to;
  };
  thread_local std::vector<Link> links;
  links.clear();
  for (Index k = first_[vertex]; k < first_[vertex + 1]; ++k) {
    const Triangle& triangle = mesh_.triangles[triangles_[k]];
    const std::size_t corner = triangle[0] == vertex ? 0 : triangle[1] == vertex ? 1 : 2;
    links.push_back({triangle[(corner + 1) % 3], triangle[(corner + 2) % 3]});
  }
  if (links.empty()) refuse_rings("vertex without triangles", vertex);
  std::sort(links.begin(), links.end(), [](Link a, Link b) { return a.from < b.from; });
  const auto link_from = [](Index from) {
    const auto at = std::lower_bound(links.begin(), links.end(), from,
                                     [](Link link, Index value) { return link.from < value; });
    return at != links.end() && at->from == from ? &*at : nullptr;
  };

  const bool closed = std::all_of(links.begin(), links.end(),
                                  [&](Link link) { return link_from(link.to) != nullptr; });
  Index start = links.front().from;
  if (!closed) {  // the ring begins at the neighbour that follows no other
    thread_local std::vector<Index> followers;
    followers.clear();
    for (const Link& link : links) followers.push_back(link.to);
    std::sort(followers.begin(), followers.end());
    for (const Link& link : links)
      if (!std::binary_search(followers.begin(), followers.end(), link.from)) start = link.from;
  }
  ring.closed = closed;
  ring.neighbours.assign(1, start);
  for (const Link* link = link_from(start);
       link != nullptr && ring.neighbours.size() <= links.size(); link = link_from(link->to)) {
    if (link->to == start) break;
    ring.neighbours.push_back(link->to);
  }
  if (ring.neighbours.size() != links.size() + (ring.closed ? 0 : 1))
    refuse_rings("vertex with several fans", vertex);
}

Ring Rings::find(Index vertex) const {
  Ring ring;
  find(vertex, ring);
  return ring;
}

}  // namespace plait::naive
