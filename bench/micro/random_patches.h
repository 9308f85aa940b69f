// Random patches to read, and the times of the single reads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>
#include <thread>
#include <vector>

#include "micro/support.h"
#include "plait/extend/edge_index.h"

namespace plait::bench {

/// `count` faces below `limit`. All are equally likely, or (Zipf) the n-th of them has a weight of
/// 1/n.
inline std::vector<FaceId> draw(bool zipf, std::uint64_t limit, int count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::vector<FaceId> faces(limit);
  std::iota(faces.begin(), faces.end(), FaceId{0});
  std::ranges::shuffle(faces, std::mt19937_64(1));  // frequent faces lie apart
  std::vector<double> weights(limit, 1.0);
  for (std::uint64_t at = 0; zipf && at < limit; ++at) weights[at] /= static_cast<double>(at + 1);
  std::discrete_distribution<std::uint64_t> distribution(weights.begin(), weights.end());
  std::vector<FaceId> drawn(static_cast<std::size_t>(count));
  for (FaceId& face : drawn) face = faces[distribution(random)];
  return drawn;
}

/// The faces of each of `threads` threads: `count` altogether.
inline std::vector<std::vector<FaceId>> draw_for_threads(int threads, bool zipf,
                                                         std::uint64_t limit, int count,
                                                         unsigned seed) {
  std::vector<std::vector<FaceId>> faces;
  faces.reserve(static_cast<std::size_t>(threads));
  for (int thread = 0; thread < threads; ++thread)
    faces.push_back(draw(zipf, limit, count / threads, seed + static_cast<unsigned>(thread)));
  return faces;
}

/// Calls read(thread, face) for the faces of each thread, and returns nanoseconds of each call.
template <class Read>
std::vector<double> latencies(const std::vector<std::vector<FaceId>>& faces_of, Read read) {
  std::vector<std::vector<double>> times(faces_of.size());
  std::vector<std::thread> threads;
  for (std::size_t thread = 0; thread < faces_of.size(); ++thread)
    threads.emplace_back([&, thread] {
      for (const FaceId face : faces_of[thread])
        times[thread].push_back(1e9 * seconds([&] { read(thread, face); }));
    });
  for (std::thread& thread : threads) thread.join();
  std::vector<double> all;
  for (const std::vector<double>& of : times) all.insert(all.end(), of.begin(), of.end());
  return all;
}

}  // namespace plait::bench
