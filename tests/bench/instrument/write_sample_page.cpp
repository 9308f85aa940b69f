// write_sample_page FILE: the page of sample_page.h, for page_in_browser_test.sh.
#include <fstream>

#include "sample_page.h"

int main(int count, char** arguments) {
  if (count != 2) return 2;
  std::ofstream(arguments[1], std::ios::binary) << to_html(plait::test::sample_page());
  return 0;
}
