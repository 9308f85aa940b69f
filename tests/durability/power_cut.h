// tests/durability/power_cut.h: what the disk may hold when the power fails.
//
// The model: a file's bytes are on the disk once the file was synced, a name once its directory
// was. Of what was written since, each run of 512 bytes is on the disk or not, whatever became of
// the others, as it was then or at any operation in between; so is each name and each file's size.
// This allows more than any file system does, and nothing that POSIX forbids.
//
// What is stored through a mapping passes no seam; it is found by comparing every file with what it
// was at the operation before.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "durability/faults.h"
#include "io/file_operations.h"

namespace plait::test {

/// While it lives it is the process's hook of file operations, and a power cut is tried before
/// every one that may change something below `root`.
class PowerCut final : public FileOperationHook {
 public:
  /// Keeps each different outcome with what `note()` says at that moment. `per_operation` outcomes
  /// of each operation: nothing unsynced is there, all of it is, and the rest at random. Besides,
  /// of every file that is not all on the disk: this file newest, all others oldest.
  PowerCut(std::filesystem::path root, std::uint64_t seed, int per_operation,
           std::function<std::uint64_t()> note);
  ~PowerCut();
  PowerCut(const PowerCut&) = delete;
  PowerCut& operator=(const PowerCut&) = delete;

  Verdict before(const FileOperation& operation) noexcept override;
  void after(const FileOperation& operation) noexcept override;

  struct Outcome {
    std::uint64_t note = 0, operation = 0;
    std::set<std::filesystem::path> directories;  ///< relative to root, as the files
    std::map<std::filesystem::path, std::shared_ptr<const std::vector<std::byte>>> files;

    /// Makes `directory` hold this outcome and nothing else.
    void put_into(const std::filesystem::path& directory) const;
  };
  const std::vector<Outcome>& outcomes() const { return outcomes_; }
  std::uint64_t operations() const { return operations_; }

 private:
  static constexpr std::size_t kSectorBytes = 512;
  using Bytes = std::vector<std::byte>;

  struct ByContent {
    static std::string_view text(const Bytes& bytes) {
      return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    bool operator()(const std::shared_ptr<const Bytes>& a,
                    const std::shared_ptr<const Bytes>& b) const {
      return text(*a) < text(*b);
    }
  };
  /// What a name in a directory means: nothing, or the node of that number.
  static constexpr int kNothing = -1, kRoot = 0;
  using States = std::vector<int>;  ///< on the disk, then those seen since
  struct Node {
    bool is_directory = false;
    std::map<std::string, States> names;                  ///< of a directory
    Bytes latest, durable;                                ///< of a file
    std::vector<std::uint64_t> sizes;                     ///< on the disk, then those seen since
    std::map<std::uint64_t, std::vector<Bytes>> sectors;  ///< likewise, of those that changed
  };

  /// Which of the states that the disk may hold an outcome has; with `node` that node's newest ones
  /// in place of its oldest.
  struct Choice {
    enum class Kind : std::uint8_t { kOldest, kNewest, kRandom };
    Kind kind = Kind::kOldest;
    int node = kNothing;
  };

  bool concerns(const std::filesystem::path& path) const;
  /// What a path's states are by the newest names; nullptr if its directory is not there.
  States* states_of(const std::filesystem::path& path);
  int newest(const std::filesystem::path& path);
  int adopt(const std::filesystem::path& path);
  void look();
  void look(int directory, const std::filesystem::path& path);
  static void look_at(Node& file, const std::filesystem::path& path);
  static void make_durable(Node& file);
  static bool is_pending(const Node& file) {
    return file.sizes.size() > 1 || !file.sectors.empty();
  }
  void cut();
  void keep_outcome(Choice choice);
  void put(int directory, const std::filesystem::path& name, Choice choice, Outcome& outcome);
  Bytes content(const Node& file, Choice choice);
  std::size_t choose(std::size_t count, Choice::Kind kind);

  std::filesystem::path root_;
  std::mt19937_64 random_;
  int per_operation_;
  std::function<std::uint64_t()> note_;
  std::mutex mutex_;
  std::deque<Node> nodes_;
  std::set<std::shared_ptr<const Bytes>, ByContent> contents_;  ///< each once
  std::vector<Outcome> outcomes_;
  std::uint64_t operations_ = 0;
};

}  // namespace plait::test
