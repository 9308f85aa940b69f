#include "durability/power_cut.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <string_view>
#include <utility>

namespace plait::test {
namespace {

namespace fs = std::filesystem;

/// Past the seam that this stands in.
std::vector<std::byte> content_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::vector<std::byte> result(bytes.size());
  if (!bytes.empty()) std::memcpy(result.data(), bytes.data(), bytes.size());
  return result;
}

}  // namespace

PowerCut::PowerCut(fs::path root, std::uint64_t seed, int per_operation,
                   std::function<std::uint64_t()> note)
    : root_(std::move(root)), random_(seed), per_operation_(per_operation), note_(std::move(note)) {
  nodes_.emplace_back().is_directory = true;
  // What is there already has been there for long.
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root_)) {
    const int node = adopt(entry.path());
    *states_of(entry.path()) = {node};
    make_durable(nodes_[static_cast<std::size_t>(node)]);
  }
  set_file_operation_hook(this);
}

PowerCut::~PowerCut() { set_file_operation_hook(nullptr); }

FileOperationHook::Verdict PowerCut::before(const FileOperation& operation) noexcept {
  if (is_harmless(operation.kind) || !concerns(operation.path)) return {};
  const std::scoped_lock lock(mutex_);
  ++operations_;
  look();
  cut();
  return without_waiting(operation);
}

void PowerCut::after(const FileOperation& operation) noexcept {
  using Kind = FileOperation::Kind;
  if (!concerns(operation.path)) return;
  const std::scoped_lock lock(mutex_);
  switch (operation.kind) {
    case Kind::kCreate:
    case Kind::kMakeDirectory:
      states_of(operation.path)->push_back(adopt(operation.path));
      break;
    case Kind::kRemove:
      states_of(operation.path)->push_back(kNothing);
      break;
    case Kind::kRename: {
      const int node = newest(operation.path);
      states_of(operation.path)->push_back(kNothing);
      states_of(*operation.to)->push_back(node);
      break;
    }
    case Kind::kExchange: {
      const int node = newest(operation.path), other = newest(*operation.to);
      states_of(operation.path)->push_back(other);
      states_of(*operation.to)->push_back(node);
      break;
    }
    case Kind::kSync:
      // What another thread wrote meanwhile counts as written after it.
      if (const int node = newest(operation.path); node != kNothing)
        make_durable(nodes_[static_cast<std::size_t>(node)]);
      break;
    case Kind::kSyncDirectory:
      if (const int node = newest(operation.path); node != kNothing)
        for (auto& [name, states] : nodes_[static_cast<std::size_t>(node)].names)
          states = {states.back()};
      break;
    default:
      break;
  }
}

bool PowerCut::concerns(const fs::path& path) const {
  return std::string_view(path.native()).starts_with(root_.native());
}

PowerCut::States* PowerCut::states_of(const fs::path& path) {
  const fs::path parent = path.parent_path();
  const int directory = parent == root_ ? kRoot : newest(parent);
  if (directory == kNothing || !nodes_[static_cast<std::size_t>(directory)].is_directory)
    return nullptr;
  States& states = nodes_[static_cast<std::size_t>(directory)].names[path.filename()];
  if (states.empty()) states.push_back(kNothing);
  return &states;
}

int PowerCut::newest(const fs::path& path) {
  if (path == root_) return kRoot;
  const States* const states = concerns(path) ? states_of(path) : nullptr;
  return states == nullptr ? kNothing : states->back();
}

int PowerCut::adopt(const fs::path& path) {
  Node& node = nodes_.emplace_back();
  node.is_directory = fs::is_directory(path);
  node.sizes = {0};
  if (!node.is_directory) look_at(node, path);
  return static_cast<int>(nodes_.size() - 1);
}

void PowerCut::look() { look(kRoot, root_); }

void PowerCut::look(int directory, const fs::path& path) {
  for (const auto& [name, states] : nodes_[static_cast<std::size_t>(directory)].names) {
    if (states.back() == kNothing) continue;
    Node& node = nodes_[static_cast<std::size_t>(states.back())];
    if (node.is_directory)
      look(states.back(), path / name);
    else
      look_at(node, path / name);
  }
}

void PowerCut::look_at(Node& file, const fs::path& path) {
  Bytes now = content_of(path);
  if (now.size() != file.latest.size()) file.sizes.push_back(now.size());
  for (std::size_t at = 0; at < now.size(); at += kSectorBytes) {
    Bytes after(kSectorBytes), before(kSectorBytes);
    std::memcpy(after.data(), &now[at], std::min(kSectorBytes, now.size() - at));
    if (at < file.latest.size())
      std::memcpy(before.data(), &file.latest[at], std::min(kSectorBytes, file.latest.size() - at));
    if (after == before) continue;
    std::vector<Bytes>& versions = file.sectors[at];
    if (versions.empty()) versions.push_back(before);
    versions.push_back(after);
  }
  file.latest = std::move(now);
}

void PowerCut::make_durable(Node& file) {
  file.durable = file.latest;
  file.sizes = {file.latest.size()};
  file.sectors.clear();
}

std::size_t PowerCut::choose(std::size_t count, Choice::Kind kind) {
  if (kind == Choice::Kind::kOldest) return 0;
  if (kind == Choice::Kind::kNewest) return count - 1;
  return random_() % count;
}

void PowerCut::cut() {
  keep_outcome({Choice::Kind::kOldest});
  keep_outcome({Choice::Kind::kNewest});
  for (int i = 2; i < per_operation_; ++i) keep_outcome({Choice::Kind::kRandom});
  for (std::size_t node = 0; node < nodes_.size(); ++node)
    if (is_pending(nodes_[node])) keep_outcome({Choice::Kind::kOldest, static_cast<int>(node)});
}

PowerCut::Bytes PowerCut::content(const Node& file, Choice choice) {
  Bytes bytes = file.durable;
  for (const auto& [at, versions] : file.sectors) {
    const Bytes& version = versions[choose(versions.size(), choice.kind)];
    bytes.resize(std::max(bytes.size(), at + kSectorBytes));
    std::memcpy(&bytes[at], version.data(), kSectorBytes);
  }
  bytes.resize(file.sizes[choose(file.sizes.size(), choice.kind)]);
  return bytes;
}

void PowerCut::put(int directory, const fs::path& name, Choice choice, Outcome& outcome) {
  outcome.directories.insert(name);
  for (const auto& [entry, states] : nodes_[static_cast<std::size_t>(directory)].names) {
    const bool newest =
        choice.node != kNothing && std::ranges::find(states, choice.node) != states.end();
    const int state = newest ? choice.node : states[choose(states.size(), choice.kind)];
    if (state == kNothing) continue;
    const fs::path path = name == "." ? fs::path(entry) : name / entry;
    const Node& node = nodes_[static_cast<std::size_t>(state)];
    if (node.is_directory) {
      put(state, path, choice, outcome);
      continue;
    }
    const Choice of_file{state == choice.node ? Choice::Kind::kNewest : choice.kind};
    outcome.files[path] =
        *contents_.insert(std::make_shared<const Bytes>(content(node, of_file))).first;
  }
}

void PowerCut::keep_outcome(Choice choice) {
  Outcome outcome{note_(), operations_, {}, {}};
  put(kRoot, ".", choice, outcome);
  const bool known = std::ranges::any_of(outcomes_, [&](const Outcome& other) {
    return other.note == outcome.note && other.files == outcome.files &&
           other.directories == outcome.directories;
  });
  if (!known) outcomes_.push_back(std::move(outcome));
}

void PowerCut::Outcome::put_into(const fs::path& directory) const {
  // Files are overwritten rather than made anew, which some file systems are slow at.
  for (auto entry = fs::recursive_directory_iterator(directory);
       entry != fs::recursive_directory_iterator(); ++entry)
    if (entry->is_regular_file() && !files.contains(entry->path().lexically_relative(directory)))
      fs::remove(entry->path());
  for (const fs::path& name : directories) fs::create_directories(directory / name);
  for (const auto& [name, bytes] : files)
    std::ofstream(directory / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes->data()),
               static_cast<std::streamsize>(bytes->size()));
}

}  // namespace plait::test
