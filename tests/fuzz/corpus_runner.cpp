// tests/fuzz/corpus_runner.cpp: replaces libFuzzer in builds without it. Runs the target with an
// empty input and with every given file, and every file in a given directory, in the order of their
// names. A finding ends the program; then the last line of the output names the file.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

bool feed_file(const std::filesystem::path& path) {
  std::printf("%s\n", path.c_str());
  std::fflush(stdout);
  std::ifstream file(path, std::ios::binary);
  if (!file) return false;
  const std::string content(std::istreambuf_iterator<char>(file), {});
  // Memory of exactly that size, so that the address sanitizer detects access to the first byte
  // after it.
  const auto bytes = std::make_unique<std::uint8_t[]>(content.size());
  std::copy(content.begin(), content.end(), bytes.get());
  LLVMFuzzerTestOneInput(bytes.get(), content.size());
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
  for (int i = 1; i < argument_count; ++i)
    for (const std::filesystem::path& path : files_at(arguments[i])) {
      if (!feed_file(path)) {
        std::fprintf(stderr, "corpus_runner: %s: cannot be read\n", path.c_str());
        return 1;
      }
      ++inputs;
    }
  if (inputs == 0) {
    std::fprintf(stderr, "corpus_runner: no input; usage: PROGRAM FILE_OR_DIRECTORY...\n");
    return 1;
  }
  std::printf("%d inputs and the empty one passed\n", inputs);
  return 0;
}
