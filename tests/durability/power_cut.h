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
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <set>
#include <string_view>
#include <vector>

#include "durability/faults.h"
#include "plait/file_operations.h"

namespace plait::test {

/// While it lives it is the process's hook of file operations, and a power cut is tried before
/// every one that may change something below `root`.
class PowerCut final : public FileOperationHook {
 public:
  /// Keeps each different outcome with what `note()` says at that moment. `per_operation` outcomes
  /// of each operation: nothing unsynced is there, all of it is, and the rest at random.
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
  struct FileState {
    Bytes latest;
    std::vector<std::uint64_t> sizes;                     ///< on the disk, then those seen since
    std::map<std::uint64_t, std::vector<Bytes>> sectors;  ///< likewise, of those that changed
    Bytes durable;
  };
  /// Nothing, a directory, or a file by its number.
  static constexpr int kNothing = -1, kDirectory = -2;
  using Names = std::map<std::filesystem::path, std::vector<int>>;  ///< on the disk, then since

  enum class Choice : std::uint8_t { kOldest, kNewest, kRandom };

  bool concerns(const std::filesystem::path& path) const;
  int adopt(const std::filesystem::path& path);
  void look();
  void look_at(FileState& file, const std::filesystem::path& path);
  void make_durable(FileState& file);
  void cut();
  void keep_outcome(Choice choice);
  std::size_t choose(std::size_t count, Choice choice);

  std::filesystem::path root_;
  std::mt19937_64 random_;
  int per_operation_;
  std::function<std::uint64_t()> note_;
  std::mutex mutex_;
  Names names_;
  std::vector<FileState> files_;
  std::set<std::shared_ptr<const Bytes>, ByContent> contents_;  ///< each once
  std::vector<Outcome> outcomes_;
  std::uint64_t operations_ = 0;
};

}  // namespace plait::test
