"""Pages of results: one file of HTML each, which fetches nothing, with pictures to hover over and tables that sort."""
