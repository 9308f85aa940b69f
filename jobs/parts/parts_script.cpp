#include "parts/parts_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// For the shell: in single quotes.
std::string shell_quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

}  // namespace

SbatchScript::SbatchScript(const std::filesystem::path& script, const std::filesystem::path& plan,
                           std::uint32_t parts, std::uint32_t longest)
    : file_(script, Existing::kRefuse) {
  const std::string absolute = std::filesystem::absolute(plan).lexically_normal().native();
  std::string text = fmt::format(
      "#!/bin/sh\n"
      "# Makes the parts of the plan, one in each task of the array:\n");
  for (std::uint32_t first = 0; first < parts; first += longest) {
    const std::uint32_t last = std::min(longest, parts - first) - 1;
    text += first == 0
                ? fmt::format("#   sbatch --array=0-{} {}\n", last, script.filename().native())
                : fmt::format("#   sbatch --array=0-{} {} --offset {}\n", last,
                              script.filename().native(), first);
  }
  text += fmt::format(
      "# Then plait join prints the parts that are missing, as a list for --array.\n"
      "#SBATCH --array=0-{}\n"
      "#SBATCH --ntasks=1\n"
      "#SBATCH --requeue\n"
      "exec plait part {} \"$SLURM_ARRAY_TASK_ID\" \"$@\"\n",
      std::min(longest, parts) - 1, shell_quoted(absolute));
  build_output(file_, [&] { file_.file().write_at(0, std::as_bytes(std::span(text))); });
}

PLAIT_END_NAMESPACE
