// tests/fuzz/corpus_runner.cpp: replaces libFuzzer in builds without it. Runs the target with an
// empty input and with every given file, and every file in a given directory, in the order of their
// names. A finding ends the program; then the last line of the output names the file.
//
//   PROGRAM [--mutations N [--seed S]] FILE_OR_DIRECTORY...
//
// With --mutations, it then runs N inputs that are mutated from these files, the same ones for the
// same seed. It does not look at what the target reaches, as libFuzzer does, but it is fast: a
// release build takes a million inputs in a minute or two. The file finding-SEED-NUMBER in the
// working directory is the input that ended the program.
#include <algorithm>
#include <array>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Input = std::vector<std::uint8_t>;
/// Those that were read, and the one that runs now, which a finding writes to a file.
std::vector<Input> inputs_read;
Input running;
std::string finding;

/// Memory of exactly that size, so that the address sanitizer detects access to the first byte
/// after it.
void feed(const Input& content) {
  const auto bytes = std::make_unique<std::uint8_t[]>(content.size());
  std::copy(content.begin(), content.end(), bytes.get());
  LLVMFuzzerTestOneInput(bytes.get(), content.size());
}

void keep_finding() {
  if (finding.empty()) return;
  if (std::FILE* const file = std::fopen(finding.c_str(), "wb")) {
    std::fwrite(running.data(), 1, running.size(), file);
    std::fclose(file);
    std::fprintf(stderr, "%s has the input\n", finding.c_str());
  }
}

void on_signal(int number) {
  keep_finding();
  std::signal(number, SIG_DFL);
  std::raise(number);
}

/// A few changes of the kinds that libFuzzer makes.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  Input next() {
    Input input = inputs_read[below(inputs_read.size())];
    for (std::size_t changes = 1 + below(5); changes > 0; --changes) change(input);
    return input;
  }

 private:
  std::size_t below(std::size_t end) { return static_cast<std::size_t>(random_() % end); }
  void change(Input& input) {
    constexpr std::size_t kMost = 8192;
    constexpr std::array<std::uint8_t, 6> kEdges = {0x00, 0x01, 0x7f, 0x80, 0xfe, 0xff};
    const std::size_t at = input.empty() ? 0 : below(input.size());
    const auto place = input.begin() + static_cast<std::ptrdiff_t>(at);
    const std::size_t part =
        input.empty() ? 0 : below(std::min<std::size_t>(32, input.size() - at));
    const auto end = place + static_cast<std::ptrdiff_t>(part);
    switch (below(8)) {
      case 0:
        if (!input.empty()) *place ^= static_cast<std::uint8_t>(1u << below(8));
        break;
      case 1:
        if (!input.empty()) *place = static_cast<std::uint8_t>(random_());
        break;
      case 2:
        if (!input.empty()) *place = kEdges[below(kEdges.size())];
        break;
      case 3:
        input.erase(place, end);
        break;
      case 4:
        if (input.size() < kMost)
          input.insert(place, 1 + below(16), static_cast<std::uint8_t>(random_()));
        break;
      case 5: {  // a part of another input
        const Input& other = inputs_read[below(inputs_read.size())];
        const std::size_t from = other.empty() ? 0 : below(other.size());
        if (input.size() < kMost)
          input.insert(place, other.begin() + static_cast<std::ptrdiff_t>(from), other.end());
        break;
      }
      case 6:
        for (auto each = place; each != end; ++each) *each = static_cast<std::uint8_t>(random_());
        break;
      default:
        if (input.size() > 8) input.resize(8 + below(input.size() - 8));
    }
  }

  std::mt19937_64 random_;
};

void run_mutations(std::uint64_t count, std::uint64_t seed) {
  for (const int number : {SIGILL, SIGTRAP, SIGSEGV, SIGABRT, SIGFPE, SIGBUS})
    std::signal(number, on_signal);
  Mutator mutator(seed);
  for (std::uint64_t number = 0; number < count; ++number) {
    running = mutator.next();
    finding = "finding-" + std::to_string(seed) + "-" + std::to_string(number);
    feed(running);
  }
  finding.clear();
  std::printf("%llu mutations of seed %llu passed\n", static_cast<unsigned long long>(count),
              static_cast<unsigned long long>(seed));
}

bool feed_file(const std::filesystem::path& path) {
  std::printf("%s\n", path.c_str());
  std::fflush(stdout);
  std::ifstream file(path, std::ios::binary);
  if (!file) return false;
  const std::string content(std::istreambuf_iterator<char>(file), {});
  inputs_read.emplace_back(content.begin(), content.end());
  feed(inputs_read.back());
  return true;
}

std::vector<std::filesystem::path> files_at(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return {path};
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(path)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

int main(int argument_count, char** arguments) {
  constexpr std::uint8_t kNothing = 0;
  LLVMFuzzerTestOneInput(&kNothing, 0);
  int inputs = 0;
  std::uint64_t mutations = 0, seed = 1;
  for (int i = 1; i < argument_count; ++i) {
    const std::string argument = arguments[i];
    if ((argument == "--mutations" || argument == "--seed") && i + 1 < argument_count) {
      (argument == "--seed" ? seed : mutations) = std::strtoull(arguments[++i], nullptr, 10);
      continue;
    }
    for (const std::filesystem::path& path : files_at(argument)) {
      if (!feed_file(path)) {
        std::fprintf(stderr, "corpus_runner: %s: cannot be read\n", path.c_str());
        return 1;
      }
      ++inputs;
    }
  }
  if (inputs == 0) {
    std::fprintf(stderr,
                 "corpus_runner: no input; usage: PROGRAM [--mutations N [--seed S]] "
                 "FILE_OR_DIRECTORY...\n");
    return 1;
  }
  std::printf("%d inputs and the empty one passed\n", inputs);
  if (mutations > 0) run_mutations(mutations, seed);
  return 0;
}
