#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <utility>

#include "instrument/html_page.h"
#include "paper/document.h"
#include "plait/error.h"

namespace plait::paper {
namespace {

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(ErrorCode::kNotFound, "read " + path.native() + ": no such picture");
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

instrument::Table page_table(const DocumentTable& table) {
  instrument::Table page;
  for (std::size_t column = 0; column < table.columns.size(); ++column)
    page.columns.push_back({table.columns[column], column != 0});
  for (const std::vector<std::string>& row : table.rows)
    page.rows.push_back({{row.begin(), row.end()}});
  return page;
}

}  // namespace

std::string to_html(const Document& document, const std::string& subtitle,
                    const std::string& report_json) {
  instrument::HtmlPage page(document.title(), subtitle);
  for (const Document::Part& part : document.parts()) switch (part.kind) {
      case Document::Kind::kHeading:
        page.section(part.text);
        break;
      case Document::Kind::kParagraph:
        page.paragraph(part.text);
        break;
      case Document::Kind::kCommand:
        page.command(part.text);
        break;
      case Document::Kind::kTable:
        page.table(page_table(part.table));
        break;
      case Document::Kind::kPicture:
        page.picture({.title = part.text}, content_of(part.file));
        break;
    }
  page.embed("report", nlohmann::ordered_json::parse(report_json));
  return page.html();
}

}  // namespace plait::paper
