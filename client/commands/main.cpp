#include "commands/torquectl.h"

int main(int argc, char** argv)
{
  return torqued::torquectl(argc, argv);
}
