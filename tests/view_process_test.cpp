#include "catch.h"
#include "process.h"
#include "temporary_folder.h"
#include "view_client.h"

#include "robot/files/load.h"
#include "wire/codec.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fmt/format.h>
#include <lcm/lcm-cpp.hpp>
#include <limits>
#include <memory>
#include <sstream>
#include <thread>

namespace view_process_test
{

using namespace torqued;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

namespace
{

// what it says then, tells nothing about the program's own memory
#if defined(__SANITIZE_ADDRESS__)
constexpr bool kSanitized = true;
#elif defined(__has_feature)
constexpr bool kSanitized = __has_feature(address_sanitizer);
#else
constexpr bool kSanitized = false;
#endif

std::unique_ptr<Process> torqued_of(const std::string& robot, const TemporaryFolder& folder)
{
  return std::make_unique<Process>(std::vector<std::string>{TORQUED, "--robot", robot}, folder.file(robot));
}

// MB
double resident_memory(const Process& process)
{
  std::istringstream status(read_file(fmt::format("/proc/{}/status", process.pid())));
  for (std::string word; status >> word;)
    if (word == "VmRSS:")
    {
      double kilobytes = 0.0;
      status >> kilobytes;
      return kilobytes / 1024.0;
    }
  return 0.0;
}

std::size_t open_files(const Process& process)
{
  const std::filesystem::directory_iterator files(fmt::format("/proc/{}/fd", process.pid()));
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

std::size_t count(const std::string& text, const std::string& part)
{
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++found;
  return found;
}

// Connections that never finish a request: of two, one sends nothing, the other one a byte every half second.
class SlowOnes
{
public:
  SlowOnes(int port, int how_many)
  {
    for (int i = 0; i < how_many; ++i)
    {
      connections_.emplace_back(port);
      CHECK(connections_.back().open());
      if (i % 2 == 0)
        connections_.back().send("GET / HTTP/1.1\r\nX: ");
    }
    thread_ = std::thread(
        [this]
        {
          while (!done_)
          {
            for (std::size_t i = 0; i < connections_.size(); i += 2)
              connections_[i].send("a");
            for (int i = 0; i < 50 && !done_; ++i)
              std::this_thread::sleep_for(10ms);
          }
        });
  }
  ~SlowOnes()
  {
    done_ = true;
    thread_.join();
  }
  SlowOnes(const SlowOnes&) = delete;
  SlowOnes& operator=(const SlowOnes&) = delete;

private:
  std::vector<Connection> connections_;
  std::atomic<bool> done_ = false;
  std::thread thread_;
};

} // namespace

TEST_CASE("view outlives its daemon, and shows the next one's robot", "[view_process]")
{
  const TemporaryFolder folder;
  auto torqued = torqued_of("ck", folder);
  View view;
  CHECK(view.robot() == "ck");
  torqued->signal(SIGKILL);
  torqued->wait();
  CHECK(view.robot() == "ck");
  torqued = torqued_of("rk", folder);
  CHECK(wait_for([&] { return view.robot() == "rk"; }));
  view.process().signal(SIGINT);
  CHECK(view.process().wait() == 0);
}

TEST_CASE("view answers only who addresses this machine, only for reading, and only its pages", "[view_process]")
{
  const TemporaryFolder folder;
  const auto torqued = torqued_of("ck", folder);
  View view;
  const int port = view.port();
  const std::string host = view.host();
  CHECK_FALSE(Connection(port, "127.0.0.2").open());

  for (const std::string path : {"/", "/document"})
  {
    const HttpAnswer answer = view.get(path);
    CHECK(answer.status == 200);
    CHECK(answer.head.find("\r\nCache-Control: no-store\r\n") != std::string::npos);
    CHECK(view.ask(fmt::format("GET {} HTTP/1.1\r\nHost: localhost:{}\r\n", path, port)).status == 200);
    for (const std::string& hosts :
         {std::string("Host: evil.example\r\n"), std::string("Host: 127.0.0.1\r\n"), std::string("Host:\r\n"),
          fmt::format("Host: 127.0.0.1:{}.evil.example\r\n", port), host + "Host: evil.example\r\n",
          "Host: evil.example\r\n" + host, host + host, fmt::format("X-Host: 127.0.0.1:{}\r\n", port)})
    {
      const HttpAnswer refused = view.ask(fmt::format("GET {} HTTP/1.1\r\n{}", path, hosts));
      CAPTURE(path, hosts, refused.head);
      CHECK((refused.status == 403 || refused.status == 400));
      CHECK(refused.body.find("robot") == std::string::npos);
    }
    CHECK(view.ask(fmt::format("GET http://evil.example{} HTTP/1.1\r\n{}", path, host)).status == 404);
    // none waits for a body
    for (const std::string method : {"POST", "PUT", "DELETE", "OPTIONS"})
      for (const std::string body : {"", "Content-Length: 9999999999999\r\n", "Transfer-Encoding: chunked\r\n"})
      {
        const HttpAnswer refused = view.ask(fmt::format("{} {} HTTP/1.1\r\n{}{}", method, path, host, body));
        CAPTURE(method, path, body, refused.head);
        CHECK(refused.status == 405);
      }
    const HttpAnswer head = view.ask(fmt::format("HEAD {} HTTP/1.1\r\n{}", path, host));
    CHECK(head.status == 200);
    CHECK(head.body.empty());
  }
  for (const std::string path : {"/nothing", "/document/", "/../../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd"})
    CHECK(view.get(path).status == 404);

  View::Run second = View::end_of({"--port", fmt::to_string(port)});
  CHECK(second.code == 1);
  CHECK(second.errors.ends_with(fmt::format("torquectl: --port: {} of 127.0.0.1 cannot be had, is another program "
                                            "there? 0 takes any that is free\n",
                                            port)));
}

TEST_CASE("view serves beside connections that are slow, and ends beside them", "[view_process]")
{
  const TemporaryFolder folder;
  const auto torqued = torqued_of("ck", folder);
  for (const int how_many : {50, 400})
  {
    CAPTURE(how_many);
    View view;
    const SlowOnes slow(view.port(), how_many);
    for (int i = 0; i < 20; ++i)
    {
      const auto before = Clock::now();
      REQUIRE(view.get("/").status == 200);
      REQUIRE(Clock::now() - before < 5s);
    }
    // more than a hundred do not stay
    CHECK(wait_for([&] { return open_files(view.process()) < 100 + 30; }));
    const auto before = Clock::now();
    view.process().signal(SIGTERM);
    CHECK(view.process().wait() == 0);
    CHECK(Clock::now() - before < 5s);
  }
}

TEST_CASE("whatever view is asked, its memory is bounded, and it goes on", "[view_process]")
{
  const TemporaryFolder folder;
  const auto torqued = torqued_of("ck", folder);
  View view;
  const std::size_t size = view.get("/").body.size();
  const double before = resident_memory(view.process());
  const auto check_memory = [&]
  {
    const double now = resident_memory(view.process());
    CAPTURE(before, now);
    CHECK((kSanitized || now < before + 60.0));
    CHECK(view.get("/").status == 200);
  };
  for (int i = 0; i < 1500; ++i)
    REQUIRE(view.get(i % 2 == 0 ? "/document" : "/").status == 200);
  check_memory();

  std::string ranges = "Range: bytes=0-";
  for (int i = 0; i < 1000; ++i)
    ranges += ",0-";
  const HttpAnswer whole = view.ask(fmt::format("GET / HTTP/1.1\r\n{}{}\r\n", view.host(), ranges));
  CHECK(whole.status == 200);
  CHECK(whole.body.size() == size);
  check_memory();

  const std::string megabyte(1'000'000, 'a');
  std::string many;
  for (int i = 0; i < 100'000; ++i)
    many += "X: y\r\n";
  for (const std::string& request :
       {"GET / HTTP/1.1\r\n" + view.host() + "X: " + megabyte + "\r\n\r\n", "GET / HTTP/1.1\r\n" + many + "\r\n",
        "GET /" + megabyte + " HTTP/1.1\r\n\r\n", megabyte, std::string(100'000, '\0'), std::string("GET /\r\n\r\n"),
        std::string("POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n"), std::string("\r\n\r\n")})
  {
    CAPTURE(request.substr(0, 40));
    const Connection connection(view.port());
    connection.send_all(request);
    CHECK(connection.receive(1s).find("HTTP/1.1 200") == std::string::npos);
    check_memory();
  }

  // who asks and does not read
  std::vector<Connection> deaf;
  for (int i = 0; i < 300; ++i)
  {
    deaf.emplace_back(view.port());
    deaf.back().send("GET / HTTP/1.1\r\n" + view.host() + "\r\n");
  }
  check_memory();
}

TEST_CASE("view passes over what describes no robot, says so once, and shows the next one that can be drawn",
          "[view_process]")
{
  const TemporaryFolder folder;
  const Channels channels;
  lcm::LCM bus;
  const model_info_t ck = model_info(load_robot("ck"), 1, 2, "");
  model_info_t other_links = ck, escapes = ck, not_finite = ck;
  other_links.name = "stranger";
  other_links.model_id = 17;
  other_links.A[0][0] += 1.0;
  escapes.name = "\x1b[31mred\x07";
  escapes.model_id = 18;
  not_finite.name = "heavy\x1b[2J";
  not_finite.total_mass = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::byte> buffer;
  const Bytes whole = encode(ck, buffer);
  const auto publish_all = [&]
  {
    for (const model_info_t* model : {&other_links, &escapes, &not_finite})
      bus.publish(channels.model, model);
    bus.publish(channels.model, whole.data(), static_cast<unsigned>(whole.size() - 1));
  };

  // even if they come first
  View view({}, false);
  for (int i = 0; i < 300 && count(view.errors(), "stranger") == 0; ++i)
  {
    publish_all();
    std::this_thread::sleep_for(10ms);
  }
  const auto torqued = torqued_of("ck", folder);
  REQUIRE(view.serves());
  CHECK(view.robot() == "ck");
  for (int i = 0; i < 3; ++i)
  {
    publish_all();
    std::this_thread::sleep_for(2200ms); // so that torqued names its own again
    CHECK(view.robot() == "ck");
  }
  const std::string errors = view.errors();
  CAPTURE(errors);
  CHECK(count(errors,
              "stranger (model_id 17) is named on this bus, and not shown: torqued: its model message (model_id "
              "17) describes no robot: ") == 1);
  CHECK(count(errors, "?[31mred? (model_id 18) is named on this bus, and not shown: ") == 1);
  CHECK(count(errors, "a message on TORQUED_MODEL, named \"heavy?[2J\", is passed over, as are others like it: "
                      "total_mass is nan\n") == 1);
  CHECK(std::none_of(errors.begin(), errors.end(), [](char c) { return c != '\n' && c < ' ' && c >= 0; }));

  const model_info_t rk = model_info(load_robot("rk"), 1, 2, "");
  bus.publish(channels.model, &rk);
  CHECK(wait_for([&] { return view.robot() == "rk"; }));
  view.process().signal(SIGTERM);
  CHECK(view.process().wait() == 0);
}

TEST_CASE("view goes on with its robot when another one than --robot says is named", "[view_process]")
{
  const TemporaryFolder folder;
  const auto torqued = torqued_of("ck", folder);
  View view({"--robot", "ck"});
  lcm::LCM bus;
  const model_info_t rk = model_info(load_robot("rk"), 1, 2, "");
  bus.publish(Channels().model, &rk);
  CHECK(wait_for([&] { return view.errors().find("torqued computes rk") != std::string::npos; }));
  CHECK(view.robot() == "ck");
}

TEST_CASE("view's document says how old the last answer is, and for how long torqued has been silent", "[view_process]")
{
  const TemporaryFolder folder;
  const auto torqued = torqued_of("ck", folder);
  View view;
  const auto liveness = [&]
  {
    return view.document()["liveness"];
  };
  const auto status_age = [&]
  {
    return liveness()["status_age"].get<double>();
  };
  CHECK(liveness()["answer_age"].is_null());
  CHECK(wait_for([&] { return status_age() < 0.5; }));
  CHECK(liveness()["stopping"] == false);

  const std::string walk = folder.file("walk.csv");
  REQUIRE(Process({TORQUECTL, "gait", "--robot", "ck", "--steps", "1", "-o", walk}, folder.file("gait")).wait() == 0);
  Process send({TORQUECTL, "send", "--loop", walk}, folder.file("send"));
  CHECK(wait_for([&] { return liveness()["answer_age"].is_number() && liveness()["answer_age"] < 0.5; }));
  send.signal(SIGINT);
  send.wait();
  const double age = liveness()["answer_age"].get<double>();
  std::this_thread::sleep_for(1s);
  CHECK(liveness()["answer_age"].get<double>() >= age + 0.8);
  CHECK(wait_for([&] { return status_age() < 0.5; }));

  torqued->signal(SIGSTOP);
  CHECK(wait_for([&] { return status_age() > 1.5; }));
  CHECK(liveness()["stopping"] == false);
  torqued->signal(SIGCONT);
  CHECK(wait_for([&] { return status_age() < 0.5; }));

  // another robot's daemon does not speak for this one
  lcm::LCM bus;
  status_t other{};
  other.model_id = 5;
  torqued->signal(SIGTERM);
  CHECK(wait_for([&] { return liveness()["stopping"] == true; }));
  torqued->wait();
  CHECK(wait_for(
      [&]
      {
        bus.publish(Channels().status, &other);
        return status_age() > 1.5;
      }));
  CHECK(liveness()["stopping"] == true);
}

} // namespace view_process_test
