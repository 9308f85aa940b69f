// The words and tables of the chapter about the paper. It measures nothing.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "argument_text.h"
#include "base/text.h"
#include "instrument/figure_text.h"
#include "paper/report.h"

namespace plait::paper {
namespace {

using Json = nlohmann::ordered_json;

using instrument::clock_text;
using instrument::Page;
using instrument::Paragraph;
using instrument::Picture;
using instrument::seconds_text;
using instrument::Section;
using instrument::Table;
using instrument::table_with;

std::string percent(std::uint64_t part, std::uint64_t whole) {
  return fmt::format("{:.2f} %", 100 * static_cast<double>(part) / static_cast<double>(whole));
}

void write_mesh(Page& page, const Model& paper, const Json& model) {
  const Json& tables = model["tables"];
  page.add(Section{fmt::format("{}: the mesh", paper.title)});
  page.add(Paragraph{
      fmt::format("Base mesh: {}. It is {}the paper's mesh, which is not distributed with plait.",
                  model["source"].get<std::string>(),
                  model["is_stand_in"].get<bool>() ? "not " : "what the user named as ")});
  Table table = table_with("|#vertices|#edges|#faces|#Euler number");
  table.rows.push_back({{"the paper's", format_count(paper.vertices), format_count(paper.edges),
                         format_count(paper.edges * 2 / 3), "-"}});
  table.rows.push_back(
      {{"this one", format_count(tables["vertices"]), format_count(tables["edges"]),
        format_count(tables["faces"]), std::to_string(tables["euler"].get<int>())}});
  page.add(std::move(table));
}

void write_shares(Page& page, const Model& paper, const Json& rows) {
  page.add(Section{fmt::format("{}: vertices on base edges", paper.title)});
  page.add(Paragraph{
      "A level creates 4^(k-1) vertices for each base edge of a closed mesh, and 2^(k-1) of them "
      "lie on the edge: a share of 2^(1-k) (section 2). The last columns say how many vertices "
      "there are up to the level, and how many more a format would store that gives each patch a "
      "grid of its own."});
  Table table = table_with(
      "level|#created|#on base edges|#share|#vertices up to it|#with a grid for each patch|#more");
  for (const Json& row : rows) {
    const double more = row["replicated"].get<double>() / row["vertices"].get<double>() - 1;
    table.rows.push_back(
        {{std::to_string(row["level"].get<int>()), format_count(row["born"]),
          format_count(row["on_base_edges"]), percent(row["on_base_edges"], row["born"]),
          format_count(row["vertices"]), format_count(row["replicated"]),
          fmt::format("{:.1f} %", 100 * more)}});
  }
  page.add(std::move(table));
}

void write_spans(Page& page, const Model& paper, const Json& tables) {
  page.add(Section{fmt::format("{}: spans", paper.title)});
  page.add(Paragraph{
      "The span of a set of stencils is the largest difference of edge indices inside one (section "
      "5.3): of a face's three edges, and of the five edges of a Loop stencil. It decides the size "
      "of the buffers. The paper sorts faces along the longest axis, which is the order "
      "\"spatial\" here. Its meshes have other shapes and numberings, so only the magnitude can "
      "agree."});
  Table table =
      table_with("order|#span of faces|#of Loop stencils|#median of Loop stencils|#of all edges");
  table.rows.push_back(
      {{"the paper's mesh, ordered", format_count(paper.face_span), format_count(paper.loop_span),
        "-", percent(paper.loop_span, paper.edges)}});
  for (const Json& row : tables["spans"]) {
    const std::string layout = row["layout"];
    const std::string remark = layout == "given"     ? " (before ordering)"
                               : layout == "spatial" ? " (the paper's order)"
                                                     : "";
    table.rows.push_back(
        {{layout + remark, format_count(row["face"]), format_count(row["loop"]),
          format_count(row["loop_median"]), percent(row["loop"], tables["edges"])}});
  }
  page.add(std::move(table));
}

void write_run(Table& table, const Json& row, double paper_seconds) {
  const std::string name =
      row["executor"] == "paper" ? "the paper's way, here" : row["executor"].get<std::string>();
  const std::string backend = row["backend"];
  const std::string budget = format_bytes(row["budget_bytes"]);
  if (row.contains("not_run")) {
    table.rows.push_back({{name, backend, "-", budget, "not run", "-", "-", "-", "-", "-"}});
    return;
  }
  const double seconds = row["seconds"];
  const bool on_disk = row["on_disk"];
  table.rows.push_back(
      {{name, backend, row["layout"].get<std::string>(), on_disk ? budget : "all in memory",
        seconds_text(seconds), seconds_text(row["cpu_seconds"]),
        format_bytes(row["peak_rss_bytes"]), on_disk ? format_bytes(row["stored_bytes"]) : "-",
        fmt::format("{:.1f}", 1e9 * seconds / row["vertices"].get<double>()),
        paper_seconds == 0 ? "-" : fmt::format("{:.0f} x", paper_seconds / seconds)}});
}

void write_runs(Page& page, const Model& paper, const Json& model) {
  const Json& runs = model["runs"];
  if (runs.empty()) return;
  const int levels = model["levels"];
  page.add(Section{fmt::format("{}: Loop to level {}", paper.title, levels)});
  page.add(Paragraph{
      "Positions and normals in float32, from the file of the mesh to a committed store, with "
      "fdatasync; each row is one run in a process of its own. Memory is the peak of the process, "
      "with the base mesh; for mmap, mapped pages of files count too. \"The paper's way, here\" is "
      "a recursive function over quadtrees, several passes a level, explicit reads and writes, and "
      "buffers of twice the span."});
  // Only a run to the paper's level, from as many edges, has its work.
  const bool comparable = levels == paper.levels && model["tables"]["edges"] == paper.edges;
  page.add(Paragraph{
      comparable
          ? "The paper's rows are what it printed, on a machine of its time: times tell the "
            "magnitude, not a ranking of methods. Memory is its main claim, and does not age."
          : fmt::format(
                "The paper has {} edges and level {}: other work, so its rows are not here.",
                format_count(paper.edges), paper.levels)});
  Table table = table_with(
      "executor|#backend|#order|#budget|#elapsed|#processor|#memory|#disk|#ns a vertex|#paper's "
      "time over it");
  const std::size_t budgets = comparable ? paper.elapsed.size() : 0;
  for (std::size_t at = 0; at < budgets; ++at)
    table.rows.push_back(
        {{budgets == 1 ? "the paper" : fmt::format("the paper, budget {}", at + 1), "-", "spatial",
          "-", clock_text(paper.elapsed[at]), clock_text(paper.processor_seconds),
          fmt::format("{} MB", paper.memory_bytes[at] / 1'000'000),
          fmt::format("{} GB", paper.disk_bytes / 1'000'000'000), "-", "-"}});
  const double fastest = comparable ? std::ranges::min(paper.elapsed) : 0;
  std::vector<std::string> refusals;
  for (const Json& row : runs) {
    write_run(table, row, fastest);
    if (row.contains("not_run"))
      refusals.push_back(fmt::format("Not run: {} on {}: {}.", row["executor"].get<std::string>(),
                                     row["backend"].get<std::string>(),
                                     row["not_run"].get<std::string>()));
  }
  page.add(std::move(table));
  for (std::string& refusal : refusals) page.add(Paragraph{std::move(refusal)});
  if (model["digests_equal"].is_boolean())
    page.add(Paragraph{
        model["digests_equal"].get<bool>()
            ? fmt::format("All runs have the digest {}.", model["digest"].get<std::string>())
            : "FAILED: the runs have different digests, so no figure of this table counts."});
}

void write_pictures(Page& page, const Model& paper, const Json& pictures) {
  if (pictures.empty()) return;
  page.add(Section{fmt::format("{}: pictures", paper.title)});
  for (const Json& picture : pictures)
    page.add(Picture{picture["file"].get<std::string>(), picture["caption"].get<std::string>()});
}

}  // namespace

Page make_chapter(const Json& report) {
  Page page{"The paper again"};
  page.add(Paragraph{
      "I. Guskov, \"Non-replicating indexing for out-of-core processing of semi-regular triangular "
      "surface meshes\", is where plait's index comes from. Here are its tables and figures beside "
      "those of this program. A command made all of this chapter:"});
  page.add(instrument::Command{report["command"].get<std::string>()});
  page.add(Paragraph{fmt::format("{}, {}, {}.", report["date"].get<std::string>(),
                                 report["machine"].get<std::string>(),
                                 report["plait"].get<std::string>())});
  if (report["interrupted"].get<bool>())
    page.add(Paragraph{"A signal ended the command: what is missing was not run."});
  for (const Json& model : report["models"]) {
    const Model& paper = model_from_name(model["name"].get<std::string>());
    write_mesh(page, paper, model);
    write_shares(page, paper, model["tables"]["shares"]);
    write_spans(page, paper, model["tables"]);
    write_runs(page, paper, model);
    write_pictures(page, paper, model["pictures"]);
  }
  return page;
}

}  // namespace plait::paper
