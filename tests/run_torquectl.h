/// torquectl, run inside a test.
#pragma once

#include "commands/torquectl.h"
#include "motion/csv_lines.h"
#include "motion/files.h"
#include "temporary_folder.h"

#include <cstdio>
#include <fcntl.h>
#include <string>
#include <unistd.h>
#include <vector>

namespace torqued
{

/// Takes what goes to a stream of this process into a file.
class Capture
{
public:
  Capture(std::FILE* stream, const std::string& path) : stream_(stream)
  {
    std::fflush(stream_);
    kept_ = dup(fileno(stream_));
    const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(file, fileno(stream_));
    close(file);
  }
  ~Capture()
  {
    std::fflush(stream_);
    dup2(kept_, fileno(stream_));
    close(kept_);
  }
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

private:
  std::FILE* stream_;
  int kept_;
};

struct Run
{
  int code;
  std::string out, err;
};

/// Runs torquectl in this process.
inline Run run(const std::vector<std::string>& words)
{
  const TemporaryFolder folder;
  std::vector<const char*> argv{"torquectl"};
  for (const std::string& word : words)
    argv.push_back(word.c_str());
  Run run;
  {
    const Capture out(stdout, folder.file("out"));
    const Capture err(stderr, folder.file("err"));
    run.code = torquectl(static_cast<int>(argv.size()), argv.data());
  }
  run.out = read_file(folder.file("out"));
  run.err = read_file(folder.file("err"));
  return run;
}

/// The cells of each line, the names of the columns first
inline std::vector<std::vector<std::string>> rows(const std::string& path)
{
  const std::string text = read_file(path);
  CsvReader reader(text, path);
  CsvLine line;
  std::vector<std::vector<std::string>> rows;
  while (reader.next(line))
    rows.push_back(line.cells);
  return rows;
}

} // namespace torqued
